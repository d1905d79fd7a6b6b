"""An SO-101's HAL in front of emulated servos, within the test's process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
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
HOME = [0.0, -1.0, 0.9, 0.7, 0.0, 0.3]
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


def told(*positions: float) -> dict[str, PartCommand]:
    """Rows for the arm; what is not given stays at home."""
    values = np.array([*positions, *HOME[len(positions) :]])
    arm, joint = ControlMode.JOINT_POSITION, tuple(range(5))
    return {"arm": PartCommand(arm, "", np.append(values[:5], 0.0), joint)}


def ticks(hal: So101Backend, count: int) -> None:
    for _ in range(count):
        hal.read()
        hal.apply(told())


def heard_ticks(hal: So101Backend, count: int) -> None:
    """And the servos have heard the last goals: nothing answers a write, but answers keep order."""
    ticks(hal, count)
    assert not hal._bus.silent()
