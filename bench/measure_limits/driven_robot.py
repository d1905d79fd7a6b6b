"""A robot's own simulator behind its HAL backend, seen the way the gate sees it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.equipment.kinematics import Kinematics, Pose
from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

ROBOTS = ("panda_mobile", "panda", "dual_panda")
ROBOT_BODIES = ("robot0_", "gripper0_", "mobilebase0_")


@dataclass(frozen=True)
class Moment:
    """What is measured at the start of a tick.

    positions, velocities, efforts: of every measured joint, commanded ones first. tools: by the
    part with the most joints that carries it, T_root_tool [m]. base: x, y [m] and yaw [rad] of
    base_link in odom.
    """

    positions: FloatArray
    velocities: FloatArray
    efforts: FloatArray
    tools: Mapping[str, Pose]
    base: FloatArray


@dataclass(frozen=True)
class Tick:
    """One period: what was measured before it and after it, and what every part was told.

    kind: what the drive was. is_free: since the reset nothing of the robot touched anything, and
    no arm joint was at the end of its range.
    """

    kind: str
    before: Moment
    after: Moment
    commands: Mapping[str, PartCommand]
    is_free: bool


class DrivenRobot:
    """One robot; every seed and every row of commands leads to the same numbers again.

    Attributes:
        is_free: as in `Tick`, up to now.
    """

    def __init__(self, robot: str) -> None:
        if robot not in ROBOTS:
            raise ConfigError(expected("measure_limits", "a robot with a simulator", robot, ROBOTS))
        self.robot: RobotManifest = load_robot(robot)
        self.backend: RobosuiteBackend | MujocoBackend
        if robot == "panda_mobile":
            self.backend = RobosuiteBackend(SimulatorOptions(), self.robot.tick_period_ns)
        else:
            self.backend = MujocoBackend(self.robot)
        names = self.robot.measured_joint_names
        self.kinematics = Kinematics(self.robot.description_path(), names)
        self.tools: dict[str, str] = {}
        for part in sorted(self.robot.parts, key=lambda one: -len(one.joints)):
            if part.end_effector is not None:
                frame = self.robot.end_effector(part.end_effector).tool_frame
                if frame not in self.tools.values():
                    self.tools[part.name] = frame
        self.is_free = True
        self.period_s = self.robot.tick_period_ns * 1e-9

    def reset(self, seed: int) -> Moment:
        """A new episode, held for one tick."""
        self.backend.reset(seed)
        self.backend.apply({})
        self.is_free = True
        return self.look()

    def step(self, kind: str, before: Moment, commands: Mapping[str, PartCommand]) -> Tick:
        """One period with these commands; ``before`` is what `look` says now."""
        self.backend.apply(commands)
        after = self.look()
        self.is_free = self.is_free and not self._is_hindered(after)
        return Tick(kind, before, after, commands, self.is_free)

    def look(self) -> Moment:
        """What is measured now."""
        found = self.backend.read()
        pose = next(frame for frame in self.backend.transforms() if frame.child == "base_link")
        z, w = pose.rotation_xyzw[2:]
        return Moment(
            found.positions,
            found.velocities,
            found.efforts,
            {
                part: self.kinematics.pose(found.positions, tool, self.robot.base_frame)
                for part, tool in self.tools.items()
            },
            np.array([*pose.translation[:2], 2.0 * np.arctan2(z, w)]),
        )

    def indices(self, part: str) -> list[int]:
        """Wire indices of a part's joints."""
        return [self.robot.joint_names.index(name) for name in self.robot.part(part).joints]

    def _is_hindered(self, now: Moment) -> bool:
        arms = [joint for joint in self.robot.joints if joint.role == "arm"]
        for joint in arms:
            position = now.positions[self.robot.joint_names.index(joint.name)]
            if position <= joint.lower or position >= joint.upper:
                return True
        model, data = self._mujoco()
        touching = (data.contact[index] for index in range(data.ncon))
        return any(
            contact.dist < 0.0
            and any(
                self._is_own(model.body(model.geom_bodyid[geom]).name)
                for geom in (contact.geom1, contact.geom2)
            )
            for contact in touching
        )

    def _mujoco(self) -> tuple[Any, Any]:
        if isinstance(self.backend, MujocoBackend):
            return self.backend._model, self.backend._data
        sim = self.backend.env.sim
        return sim.model._model, sim.data._data

    def _is_own(self, body: str) -> bool:
        is_plain = isinstance(self.backend, MujocoBackend)
        return body != "world" if is_plain else body.startswith(ROBOT_BODIES)
