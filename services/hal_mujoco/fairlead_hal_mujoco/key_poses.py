"""Key poses of a model: where an episode starts, and what its task asks for."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_mujoco.options import MujocoOptions

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
