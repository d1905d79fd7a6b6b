"""Why a robot's model cannot be driven: every reason, where a HAL that starts says the first."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import mujoco

from fairlead.errors import ConfigError, HardwareError
from fairlead.hal.mujoco_joints import find_source
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_mujoco.model_file import load_model
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_mujoco.options import MujocoOptions

_STANDS_S = 1.0


def model_problems(robot: RobotManifest, path: Path) -> list[str]:
    """What hal_mujoco would refuse of a model: its file, or each joint; [] if nothing.

    One that it takes has to stand for a second without diverging.
    """
    try:
        model, _ = load_model(path, robot.tick_period_ns)
    except ConfigError as error:
        return [str(error)]
    return list(_refusals(model, robot)) or list(_falls(robot, path))


def _falls(robot: RobotManifest, path: Path) -> Iterator[str]:
    mujoco.set_mju_user_warning(lambda text: None)  # else it is also written to a file here
    try:
        backend = MujocoBackend(robot, next(iter(robot.safety)), MujocoOptions(model=str(path)))
        for _ in range(round(_STANDS_S / (robot.tick_period_ns * 1e-9))):
            backend.apply({})
    except (ConfigError, HardwareError) as error:
        yield str(error)
    finally:
        mujoco.set_mju_user_warning(None)


def _refusals(model: mujoco.MjModel, robot: RobotManifest) -> Iterator[str]:
    for joint in (*robot.joints, *robot.passive_joints):
        try:
            find_source(model, robot, joint, "hal_mujoco")
        except ConfigError as error:
            yield str(error)
