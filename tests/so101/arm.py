"""An SO-101's HAL in front of emulated servos, within the test's process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fairlead.robot.manifest import load_robot
from fairlead_hal_so101.calibration import (
    Arm,
    CalibratedServo,
    Calibration,
    load_calibration,
    save_calibration,
)
from fairlead_hal_so101.options import So101Options
from fairlead_hal_so101.so101_backend import So101Backend

ROBOT = load_robot("so101")
PATIENT = {"answer_timeout_s": 0.4}
"""On a busy machine the emulator may answer late."""


def as_delivered(folder: Path, arm: Arm = "follower", **change: Any) -> Path:
    """A calibration that fits servos in the middle of their turn; a change of the third."""
    servos = [
        {"joint": name, "id": one, "homing_offset_steps": 0, "direction": 1,
         "lower_steps": 0, "upper_steps": 4095}
        for one, name in enumerate(ROBOT.joint_names, start=1)
    ]  # fmt: skip
    servos[2] |= change
    path = folder / f"{arm}.yaml"
    found = tuple(CalibratedServo.model_validate(one) for one in servos)
    save_calibration(path, Calibration(robot="so101", arm=arm, servos=found))
    return path


@contextmanager
def backend(
    port: Path, calibration: Path, profile: str = "sim", **options: Any
) -> Iterator[So101Backend]:
    """The HAL's backend, holding the arm."""
    wanted = So101Options.model_validate(
        {"port": str(port), "calibration": str(calibration)} | PATIENT | options
    )
    found = So101Backend(ROBOT, profile, wanted, load_calibration(str(calibration), ROBOT))
    try:
        yield found
    finally:
        found.close()
