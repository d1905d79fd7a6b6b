"""The MJCF file of a robot: loading it, and its key poses, where episodes start and tasks end."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_mujoco.options import MujocoOptions


def load_model(path: Path, period_ns: int) -> tuple[mujoco.MjModel, int]:
    """The compiled model and its physics steps per control period.

    Args:
        period_ns: control period of the robot [ns].

    Raises:
        ConfigError: no such file, MuJoCo's own complaint about it, or a timestep that does
            not divide the control period.
    """
    if not path.is_file():
        raise ConfigError(f"hal_mujoco: expected an MJCF file, got none at {path}")
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise ConfigError(f"hal_mujoco: {path}: {' '.join(str(error).split())}") from None
    period_s = period_ns * 1e-9
    steps = round(period_s / model.opt.timestep)
    if steps < 1 or abs(steps * model.opt.timestep - period_s) > 1e-9:
        raise ConfigError(
            expected(
                f"hal_mujoco: {path}: timestep",
                f"a whole part of the control period of {period_s:g} s",
                f"{model.opt.timestep:g} s",
            )
        )
    # MuJoCo would put a diverged simulation back to its start, and nobody would notice.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    return model, steps


HOME_KEY = "home"
GOAL_KEY = "goal"


def key_qpos(model: mujoco.MjModel, name: str) -> FloatArray | None:
    """The simulator's positions of one ``<key>``, None if the model has none of that name."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, name)
    return None if index < 0 else np.array(model.key_qpos[index])


@dataclass(frozen=True)
class GoalPose:
    """The task of a model with a key ``goal``: all commanded joints there, and standing still.

    positions, tolerances: per commanded joint [rad or m]; still_below: [rad/s or m/s].
    """

    positions: FloatArray
    tolerances: FloatArray
    still_below: FloatArray

    @classmethod
    def of(
        cls, robot: RobotManifest, profile: str, options: MujocoOptions, positions: FloatArray
    ) -> GoalPose:
        """With the options' tolerances and the profile's standstill velocities."""
        measured = robot.profile(profile).measured
        within = {"rad": options.goal_tolerance_rad, "m": options.goal_tolerance_m}
        return cls(
            positions,
            np.array([within[joint.unit] for joint in robot.joints]),
            np.array([measured[name].standstill_per_s for name in robot.joint_names]),
        )

    def reached(self, positions: FloatArray, velocities: FloatArray) -> bool:
        """Whether the commanded joints are there, at rest."""
        near = np.abs(positions - self.positions) <= self.tolerances
        return bool(np.all(near & (np.abs(velocities) < self.still_below)))

    def distance(self, positions: FloatArray) -> float:
        """The largest error in tolerances: at most 1 is there."""
        return float(np.max(np.abs(positions - self.positions) / self.tolerances))
