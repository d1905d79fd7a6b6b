"""``fairlead calibrate so101`` with an arm whose horns were mounted anyhow, moved by hand."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from bench.equipment.emulated_arm import emulated_arm
from fairlead.paths import robot_dir
from fairlead_hal_so101.calibration import load_calibration
from fairlead_hal_so101.guided_calibration import end_words
from tests.cli.command import fairlead
from tests.so101.arm import ROBOT, backend
from tests.so101.calibrating import calibrate, move

HOME = [0.0, -1.0, 0.9, 0.7, 0.0, 0.3]

pytestmark = pytest.mark.processes


def test_after_it_the_hal_measures_and_moves_the_joints(tmp_path: Path) -> None:
    with emulated_arm(tmp_path / "arm", "--mounting", "3") as arm:
        code, said = calibrate(arm, tmp_path / "mine.yaml")
        assert code == 0, said
        found = load_calibration(str(tmp_path / "mine.yaml"), ROBOT)
        assert {servo.direction for servo in found.servos} == {1, -1}
        assert f"wrote {tmp_path / 'mine.yaml'} and the servos" in said
        for servo_id, position in enumerate(HOME, start=1):
            move(arm, servo_id, position)
        with backend(arm.port, tmp_path / "mine.yaml") as hal:
            np.testing.assert_allclose(hal.read().positions, HOME, atol=0.06)
        arm.order("dip")
        with backend(arm.port, tmp_path / "mine.yaml") as hal:
            assert hal.read().positions == pytest.approx(HOME, abs=0.06), "it is in the EEPROM"


def test_a_joint_that_was_not_moved_from_end_to_end_leaves_no_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    with emulated_arm(tmp_path / "arm") as arm:
        command = ("calibrate", "so101", "--port", str(arm.port), "--name", str(file))
        refused = fairlead(*command, state=tmp_path, answer="\n\n")
        wanted = "expected a way of 3.84 rad from end to end, got 0.00"
        assert refused.returncode == 1
        assert refused.stderr == f"ERROR calibrate: shoulder_pan: {wanted}\n"
    assert not file.exists()


def test_nobody_is_told_to_hold_an_arm_that_is_not_there(tmp_path: Path) -> None:
    done = fairlead("calibrate", "so101", "--port", str(tmp_path / "none"), state=tmp_path)
    assert (done.returncode, done.stdout) == (1, ""), done.stderr


def test_which_end_is_which_is_said_as_another_library_s_model_moves() -> None:
    model = mujoco.MjModel.from_xml_path(str(robot_dir("so101") / "so101.xml"))
    data = mujoco.MjData(model)

    def tool(joint: str, turned: float) -> tuple[np.ndarray, np.ndarray]:
        for name, position in zip(ROBOT.joint_names, HOME, strict=True):
            data.joint(name).qpos = position + turned * (name == joint)
        mujoco.mj_kinematics(model, data)
        hand = data.body("gripper_link")
        return hand.xpos.copy(), hand.xmat.reshape(3, 3).copy()

    axes = {"ahead": 0, "to the left": 1, "up": 2}
    for joint in ROBOT.joints[:4]:
        way = tool(joint.name, 0.1)[0] - tool(joint.name, -0.1)[0]
        said = end_words(ROBOT, joint)[1].removeprefix("the tool goes ")
        opposite = {"back": "ahead", "to the right": "to the left", "down": "up"}
        sign, axis = (-1, axes[opposite[said]]) if said in opposite else (1, axes[said])
        assert sign * way[axis] > 0.01, joint.name
    roll = ROBOT.joints[4]
    before, after = tool(roll.name, -0.1)[1], tool(roll.name, 0.1)[1]
    turn = after @ before.T  # about x, from behind clockwise if y goes to z
    clockwise = turn[2, 1] > 0
    assert end_words(ROBOT, roll)[1].startswith("the tool turned clockwise") == clockwise
    assert end_words(ROBOT, ROBOT.joints[5]) == ("the jaw closed", "the jaw open")
