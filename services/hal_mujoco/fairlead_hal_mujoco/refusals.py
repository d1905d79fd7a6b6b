"""Why a robot's model cannot be driven: every reason, where a HAL that starts says the first."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import mujoco

from fairlead.errors import ConfigError
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_mujoco.model_file import load_model
from fairlead_hal_mujoco.servos import find_source


def model_problems(robot: RobotManifest, path: Path) -> list[str]:
    """What hal_mujoco would refuse of a model: its file, or each joint; [] if nothing."""
    try:
        model, _ = load_model(path, robot.tick_period_ns)
    except ConfigError as error:
        return [str(error)]
    return list(_refusals(model, robot))


def _refusals(model: mujoco.MjModel, robot: RobotManifest) -> Iterator[str]:
    for joint in (*robot.joints, *robot.passive_joints):
        try:
            find_source(model, robot, joint)
        except ConfigError as error:
            yield str(error)
