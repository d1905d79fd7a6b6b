"""``fairlead calibrate so101`` with an arm whose horns were mounted anyhow, moved by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.equipment.emulated_arm import emulated_arm
from fairlead_hal_so101.calibration import load_calibration
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
