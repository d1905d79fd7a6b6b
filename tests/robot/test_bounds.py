"""Every declared limit names a check and a test that exist, or is said to have none."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fairlead.paths import repo_root
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.app import app
from fairlead_tools.limits import check_tests
from fairlead_tools.limits.bounds import Bound, robot_bounds
from fairlead_tools.limits.effective_limits import effective_limits

ROBOT = load_robot("panda_mobile")
BOUNDS = robot_bounds(ROBOT)
TWO_ARMED = robot_bounds(load_robot("dual_panda"))


@pytest.fixture(params=["panda sim", "panda_mobile sim", "panda_mobile hardware", "dual_panda sim"])
def bounds(request: pytest.FixtureRequest) -> list[Bound]:
    robot, profile = request.param.split()
    return robot_bounds(load_robot(robot), profile)


@cache
def case_names(file: str) -> set[str]:
    text = (repo_root() / file).read_text(encoding="utf-8")
    return set(re.findall(r'TEST_CASE\(\s*"((?:[^"\\]|\\.)*)"', text))


def checks(where: str, limit: str) -> list[str]:
    (bound,) = [b for b in BOUNDS if (b.limit.where, b.limit.name) == (where, limit)]
    return [by.check for by in bound.enforced_by]


def test_every_limit_of_the_gate_file_is_listed_once() -> None:
    listed = [(bound.limit.where, bound.limit.name) for bound in BOUNDS]
    assert len(set(listed)) == len(listed)
    assert {(limit.where, limit.name) for limit in effective_limits(ROBOT)} <= set(listed)
    protocol = set(ROBOT.profile("sim").protocol.model_dump(exclude_none=True))
    assert {name for where, name in listed if where == "protocol"} == protocol


def test_every_test_that_is_named_exists(bounds: list[Bound]) -> None:
    named = {(by.file, by.test) for bound in bounds for by in bound.enforced_by}
    assert named
    assert {(file, name) for file, name in named if name not in case_names(file)} == set()


def test_a_check_named_by_code_is_proven_by_a_test_of_that_code(bounds: list[Bound]) -> None:
    wrong = [
        by
        for bound in bounds
        for by in bound.enforced_by
        if re.match(r"G\d{3}", by.check) and not by.test.startswith(by.check[:4])
    ]
    assert wrong == []


def test_no_limit_is_enforced_by_nothing(bounds: list[Bound]) -> None:
    assert [bound.limit for bound in bounds if not bound.enforced_by] == []


@pytest.mark.parametrize(
    ("where", "limit", "codes"),
    [
        ("joint right_joint1", "effort_limit", ["G042 beyond 91"]),
        ("joint left_joint1", "effort_limit", ["G042 beyond 91"]),
        ("joint right_thumb_joint1", "upper", ["G011", "G020", "G024"]),
        ("joint left_gripper", "upper", ["G011 logs and counts it", "G020"]),
        ("joint left_gripper", "tolerance", ["G011 logs and counts it"]),
        ("joint right_thumb_joint1", "velocity_limit", ["G024 predicts by it in dex_hand_joint"]),
        ("part left_arm cartesian_delta", "gain", ["G024 predicts by it", "G040 predicts by it"]),
        ("part left_arm cartesian_pose", "lower", ["G020"]),
        ("part left_arm cartesian_pose", "angular_step_limit", ["G021", "G022"]),
        ("part right_arm cartesian_twist", "linear_limit", ["G020"]),
        ("part right_hand dex_hand_joint", "step_limit", ["G021", "G022"]),
    ],
)
def test_limits_of_a_two_armed_robot_and_their_checks(
    where: str, limit: str, codes: list[str]
) -> None:
    (bound,) = [b for b in TWO_ARMED if (b.limit.where, b.limit.name) == (where, limit)]
    assert [by.check for by in bound.enforced_by] == codes


@pytest.mark.parametrize(
    ("where", "limit", "codes"),
    [
        ("joint base_x", "velocity_limit", ["G020", "G034 predicts by it in body_twist"]),
        ("joint panda_joint1", "upper", ["G011", "G024"]),
        ("joint panda_joint1", "velocity_limit", ["G024 predicts by it in cartesian_delta"]),
        ("joint base_x", "acceleration_limit", ["G034 predicts by it"]),
        ("part base", "transitions", ["G025"]),
        ("volume reach", "keep_in lower", ["G031"]),
        ("self-collision", "clearance", ["G032"]),
        ("zone kitchen", "keep_in corners", ["G034"]),
        ("protocol", "stop_ramp_ms", ["G043"]),
        ("joint torso_height", "jump_limit", ["G013"]),
        ("joint torso_height", "upper", ["G011 logs and counts it"]),
        ("part arm cartesian_delta", "linear_limit", ["G020"]),
        ("part base joint_velocity", "step_limit", ["G021", "G022"]),
        ("protocol", "horizon_max", ["G007"]),
    ],
)
def test_limits_and_their_checks(where: str, limit: str, codes: list[str]) -> None:
    assert checks(where, limit) == codes


def invoke(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["robot", "bounds", "panda_mobile", *arguments])
    return result.exit_code, result.output


def test_a_robot_whose_limits_are_all_enforced_passes_strict() -> None:
    code, output = invoke("--strict")
    assert code == 0
    assert output.splitlines()[-1] == (
        f"panda_mobile, profile sim: {len(BOUNDS)} declared limits, {len(BOUNDS)} enforced, "
        "0 NOT ENFORCED in this release"
    )
    rows = json.loads(invoke("--json")[1])
    assert len(rows) == len(BOUNDS)
    assert Path(rows[0]["enforced_by"][0]["file"]).name == "test_absolute.cpp"


def test_limits_of_a_check_that_is_not_there_are_counted_and_strict_fails_on_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kept = {name: by for name, by in check_tests.CHECK_TESTS.items() if name != "contact"}
    monkeypatch.setattr(check_tests, "CHECK_TESTS", kept)
    code, output = invoke("--strict")
    assert code == 1
    # 11 commanded joints: the contact limit, and the effort limit that it bounds.
    assert "22 NOT ENFORCED in this release" in output.splitlines()[-1]
    assert sum("NOT ENFORCED" in line for line in output.splitlines()) == 22 + 1
