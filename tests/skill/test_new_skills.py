"""What ``skill new`` writes for arms of other modes and other numbers of joints."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
import yaml

from fairlead.policy import Executed, Observation
from fairlead.robot.manifest import load_robot
from fairlead_tools.skills.skeleton import skill_skeleton
from tests.cli.command import fairlead_here


def test_a_new_skills_joint_targets_begin_where_the_robot_is_and_again_after_a_hold(
    tmp_path: Path,
) -> None:
    robot = load_robot("panda")
    files = skill_skeleton("mine", robot, "joint_position")
    options = yaml.safe_load(files["rskill.yaml"])["policy"]["options"]["options"]
    (tmp_path / "policy.py").write_text(files["policy.py"], encoding="utf-8")
    policy = runpy.run_path(str(tmp_path / "policy.py"))["Policy"].from_options(None, options)
    limits = robot.profile("sim").parts["arm"].joint_position
    assert limits is not None
    for state in (np.linspace(0.0, 0.8, 9), np.linspace(0.5, 0.1, 9)):
        first = policy.infer(Observation(1, state, "", executed={"arm": Executed("refused", None)}))
        rows = [state[:7], *first, *policy.infer(Observation(9, state, ""))]
        steps = np.abs(np.diff(rows, axis=0)).max()
        assert 0.01 < steps <= limits.step_limits[0]


@pytest.mark.parametrize("mode", ["joint_velocity", "cartesian_delta"])
def test_a_wave_of_motions_begins_anew_after_a_hold(mode: str, tmp_path: Path) -> None:
    robot = load_robot("dual_panda")
    files = skill_skeleton("mine", robot, mode)
    (tmp_path / "policy.py").write_text(files["policy.py"], encoding="utf-8")
    policy = runpy.run_path(str(tmp_path / "policy.py"))["Policy"].from_options(
        None, {"strength": 0.9}
    )
    first, second = (policy.infer(Observation(tick, np.zeros(9), "")) for tick in (1, 9))
    assert not np.array_equal(first, second)
    held = Observation(17, np.zeros(9), "", executed={"left_arm": Executed("refused", None)})
    np.testing.assert_array_equal(policy.infer(held), first)


def test_a_delta_of_an_arm_with_five_joints_leaves_the_turn_to_it() -> None:
    robot = load_robot("panda_mobile")
    arm = robot.part("arm")
    short = robot.model_copy(update={"parts": (arm.model_copy(update={"joints": arm.joints[:5]}),)})
    manifest = yaml.safe_load(skill_skeleton("mine", short)["rskill.yaml"])
    (slot,) = manifest["action_contract"]["slots"]
    assert (slot["range"], slot["axes"]) == ([0, 2], [0, 1, 2])


def test_a_new_skill_of_a_name_that_ships_is_not_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = fairlead_here("skill", "new", "oracle-counter-to-cabinet", state=tmp_path)
    assert (done.returncode, done.stderr) == (
        1, "ERROR skill oracle-counter-to-cabinet: one of this name ships with fairlead; "
        "rename yours\n",
    )  # fmt: skip
    assert not (tmp_path / "oracle-counter-to-cabinet").exists()
