"""The words of a verdict: one mark of a rule, a unit for each magnitude, a line that fits."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import pytest

from fairlead.messages import Outcome, Verdict, decode, encode
from fairlead.modes import ControlMode
from fairlead.paths import repo_root
from fairlead.wire.gate_checks import CHECKS
from fairlead.wire.verdict_text import describe, finding_text
from tests.golden.gate_messages import SAFETY
from tests.repo.core_tests import CoreRule, core_rules

LONGEST = 160
FILES = sorted((repo_root() / "robots").glob("*/gate.*.json"))
ROBOTS = [json.loads(path.read_text()) for path in FILES]
ALIKE = {"value": 2.1750000000000003, "limit": 2.175}
"""Numbers that are told with all their digits."""


def refusal(code: int, **changes: Any) -> Verdict:
    blank = SAFETY["Verdict.released"]
    assert isinstance(blank, Verdict)
    fields = {"outcome": Outcome.REFUSED, "seq": 3, "code": code, "unit": ""} | changes
    return msgspec.structs.replace(blank, **fields)


def test_a_magnitude_is_told_with_its_unit_and_not_with_where_its_limit_is_from() -> None:
    found = refusal(
        20, row=2, part="arm", axis="linear", value=5.0, limit=0.0867, margin=-4.9, unit="m",
        limit_source="a data sheet",
    )  # fmt: skip
    said = "G020 limit: chunk 3 refused at row 2, arm linear: 5 m, limit 0.0867 m"
    assert (describe(found), finding_text(found)) == (
        said,
        "G020 limit: arm linear: 5 m, limit 0.0867 m",
    )


def test_a_rule_is_told_by_what_it_needs_whatever_its_numbers_are() -> None:
    needs = "standstill after a held tick"
    found = refusal(25, row=0, part="arm", axis="mode", value=5.0, limit=1.0, limit_source=needs)
    place = "arm mode cartesian_delta after joint_velocity: needs standstill after a held tick"
    assert finding_text(found) == f"G025 mode switch not allowed: {place}"
    assert describe(found) == f"G025 mode switch not allowed: chunk 3 refused at row 0, {place}"


def test_a_magnitude_at_its_limit_is_no_rule() -> None:
    found = refusal(25, part="arm", axis="j", value=0.05, limit=0.05, unit="m/s", limit_source="so")
    assert finding_text(found).endswith(": arm j: 0.05 m/s, limit 0.05 m/s")


def test_a_verdict_of_an_older_log_has_no_unit() -> None:
    message = refusal(20, value=5.0, limit=1.0, margin=-4.0, unit="m")
    fields = msgspec.msgpack.decode(encode(message))
    older = decode(Verdict, msgspec.msgpack.encode(fields[:-1]))
    assert older == msgspec.structs.replace(message, unit="")
    assert finding_text(older) == "G020 limit: 5, limit 1"


def _length(mode: ControlMode) -> int:
    return len(mode.yaml_name)


def places(robot: dict[str, Any], code: int) -> list[tuple[str, str]]:
    """Part and axis that a verdict of that robot may name: the longest that the code has."""
    parts = {part["name"]: part["joints"] for part in robot["parts"]}
    of_parts = [(part, joint) for part, joints in parts.items() for joint in joints]
    of_parts += [(part, "tool rotation") for part in parts]
    links = sorted((link["name"] for link in robot["kinematics"]["links"]), key=len)
    volumes = [volume["name"] for volume in robot["workspace"]["volumes"]]
    if code == 32:
        return [(max(parts, key=len), f"{links[-1]} / {links[-2]}")]
    if code == 31:
        return [(max(parts, key=len), f"{links[-1]} / {name}") for name in volumes]
    return of_parts


@pytest.mark.parametrize("rule", core_rules(), ids=lambda rule: f"G{rule.code:03d} {rule.words}")
def test_a_rule_fits_in_a_line_with_the_longest_names_of_a_shipped_robot(rule: CoreRule) -> None:
    for robot in ROBOTS:
        for part in robot["parts"]:
            axes = ["composite left out", "tool motion", *part["joints"]]
            modes = sorted((ControlMode[mode.upper()] for mode in part["modes"]), key=_length)[-2:]
            changes = rule.code == 25 and len(modes) == 2
            numbers = {"value": float(modes[0]), "limit": float(modes[1])} if changes else {}
            axis = "mode" if changes else max(axes, key=len)
            found = refusal(
                rule.code, seq=10**6, outcome=Outcome.TRUNCATED, row=63, part=part["name"],
                axis=axis, limit_source=rule.words, **numbers,
            )  # fmt: skip
            assert len(describe(found)) <= LONGEST, describe(found)


@pytest.mark.parametrize("code", [code for code, check in CHECKS.items() if check.units])
def test_numbers_fit_in_a_line_with_the_longest_names_of_a_shipped_robot(code: int) -> None:
    unit = max(CHECKS[code].units, key=len)
    for robot in ROBOTS:
        for part, axis in places(robot, code):
            found = refusal(
                code, seq=10**6, outcome=Outcome.TRUNCATED, row=63, part=part, axis=axis,
                margin=-1e-16, unit=unit, limit_source="l" * 256, **ALIKE,
            )  # fmt: skip
            assert len(describe(found)) <= LONGEST, describe(found)
