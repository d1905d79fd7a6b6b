"""A HAL that breaks the contract in one way fails the check that is about that."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import pytest

from bench.equipment import broken_hal
from fairlead_tools.conformance.hal_check import BASIS, HalCheck
from tests.conformance.quick_robot import NAME, write_quick_robot
from tests.conformance.running_hal import Wanted, check_all, rows_of

pytestmark = [pytest.mark.processes, pytest.mark.thorough]

AT_ONCE = 7
TIMING = {"tick rate", "jitter"}
"""On a busy machine anybody's ticks may come late."""
EVERY, HOLDS = (), ("base",)
FOUND_BY: dict[str, tuple[tuple[str, ...], set[str]]] = {
    "": (EVERY, set()),
    "swaps joints": (("joints",), {"joint order"}),
    "turns a sign": (EVERY, {"joint sign"}),
    "gripper in degrees": (("grippers",), {"gripper way", "gripper place"}),
    "ranges in degrees": (HOLDS, {"SI ranges"}),
    "velocities per tick": (("joints",), {"SI velocities"}),
    "tool's frame": (("tools",), {"command frame"}),
    "too fast": (("limits",), {"joint limits under cartesian rows"}),
    "ignores that leases stop": (HOLDS, {"holds when leases stop"}),
    "ignores that rows end": (HOLDS, {"holds when rows end"}),
    "ignores a stop": (HOLDS, {"holds on a stop", "a stop stays"}),
    "goes on in a hold": (HOLDS, {"holds when rows end"}),
    "drifts": (EVERY, {"a hold does not drift"}),
    "takes rows of an earlier epoch": (
        ("forged rows", "forged leases"), {"row of another epoch"},  # the others stop it
    ),
    "follows leases of an earlier epoch": (
        ("forged leases",), {"rows under: lease of an earlier epoch", "a second gate is noticed"},
    ),
    "takes rows of the past": (("forged rows",), {"row of a chunk that began in the past"}),
    "goes on after SIGSTOP": (("pause",), {"resume after SIGSTOP"}),
    "old states": (("pause",), {"resume after SIGSTOP"}),
    "dies": (EVERY, {"the HAL goes on"}),
    "raises": (EVERY, {"the HAL goes on"}),
}  # fmt: skip
"""What is asked for beside holding, and all that it fails, but for `TIMING`."""
AMONG_OTHERS: dict[str, tuple[tuple[str, ...], str]] = {
    "degrees": (("joints",), "SI positions"),
    "late": (("joints",), "command round trip"),
    "ticks too slowly": (HOLDS, "tick rate"),
    "ticks unevenly": (HOLDS, "jitter"),
    "leaves ticks out": (("joints",), "joint states"),
    "not finite": (HOLDS, "joint states"),
}
"""What touches more than one check, and the one that names it."""


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, HalCheck]]:
    folder = tmp_path_factory.mktemp("broken")
    robots = write_quick_robot(folder / "robots")
    wanted = {_id(fault): _wanted(fault) for fault in FOUND_BY | AMONG_OTHERS}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FAIRLEAD_ROBOTS", str(robots))
        yield check_all(folder, wanted, AT_ONCE)


def _id(fault: str) -> str:
    return "".join(c if c.isalnum() else "_" for c in fault.lower()) or "intact"


def _wanted(fault: str) -> Wanted:
    [only, _] = (FOUND_BY | AMONG_OTHERS)[fault]
    hal = {"command": ["python", "-m", broken_hal.__name__], "options": {"fault": fault}}
    return Wanted(NAME, hal, only=only, expected=partial(is_found, fault))


def failed(check: HalCheck) -> set[str]:
    return {row.check for row in check.rows if row.outcome == "fail"}


def is_found(fault: str, check: HalCheck) -> bool:
    if fault in AMONG_OTHERS:
        return AMONG_OTHERS[fault][1] in failed(check)
    return failed(check) - TIMING == FOUND_BY[fault][1]


@pytest.mark.parametrize("fault", FOUND_BY, ids=_id)
def test_one_fault_fails_its_own_check_and_no_other(found: dict[str, HalCheck], fault: str) -> None:
    check = found[_id(fault)]
    assert is_found(fault, check), rows_of(check, "fail")


@pytest.mark.parametrize("fault", AMONG_OTHERS, ids=_id)
def test_a_fault_that_touches_much_fails_the_check_that_names_it(
    found: dict[str, HalCheck], fault: str
) -> None:
    assert is_found(fault, found[_id(fault)])


def test_an_intact_one_is_checked_in_full(found: dict[str, HalCheck]) -> None:
    assert set(rows_of(found["intact"], "not checked")) == {"base command frame"}


@pytest.mark.parametrize("fault", ["drifts", "turns a sign"])
def test_a_robot_that_does_not_hold_or_obey_is_not_moved_any_further(
    found: dict[str, HalCheck], fault: str
) -> None:
    check = found[_id(fault)]
    [*_, broken] = [row for row in check.rows if row.outcome == "fail" and row.check in BASIS]
    left = [row for row in check.rows if row.outcome == "not checked"]
    assert {"forged leases", "limits", "pause"} <= {row.check for row in left}
    why = f"{broken.check}: failed, so the robot is not moved any further"
    assert {row.got for row in left} == {why}


def test_a_hal_that_stopped_itself_is_quoted(found: dict[str, HalCheck]) -> None:
    said = rows_of(found["raises"], "fail")["the HAL goes on"]
    assert "; stop by hal: " in said and "as a driver may" in said


def test_each_failure_says_what_was_expected_by_what_and_what_to_do(
    found: dict[str, HalCheck],
) -> None:
    rows = [row for check in found.values() for row in check.rows if row.outcome == "fail"]
    assert all(row.expected and row.source and row.got and row.fix for row in rows)
