"""Full-scale rows of one part in one mode: what a policy at its worst may send, and no more.

A row is within the mode's limits and its step limits, as the gate would have it.
"""

from __future__ import annotations

import numpy as np

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.safety_profile import profile_limits
from fairlead_tools.measure.driven_robot import Moment
from fairlead_tools.measure.rotations import exponential, quaternion_of, rotation_of

TARGETS = (ControlMode.JOINT_POSITION, ControlMode.DEX_HAND_JOINT)
HALVES = (ControlMode.CARTESIAN_DELTA, ControlMode.CARTESIAN_TWIST, ControlMode.BODY_TWIST)
MEASURED_MODES = (*TARGETS, *HALVES, ControlMode.JOINT_VELOCITY, ControlMode.CARTESIAN_POSE)
ROUNDING = 1.0 - 1e-9
"""Full scale, without being beyond it by the last bit."""
BOUND_ROOM_S = 0.25
"""A joint this close to a bound, at full speed, is told to turn back."""


class FullScaleRows:
    """The rows of one part; ``wish`` is in [-1, 1] per joint or axis, +-1 is full scale.

    turns_back: joints near a bound are told to turn back, whatever is wished. profile: whose limits
    are full scale.
    """

    def __init__(
        self,
        robot: RobotManifest,
        part: str,
        mode: ControlMode,
        turns_back: bool = True,
        profile: str = "sim",
    ) -> None:
        self.mode, self._robot, self._turns_back = mode, robot, turns_back
        self._profile = robot.profile(profile)
        self._joints = [robot.joint_names.index(name) for name in robot.part(part).joints]
        self.part = part
        self._limits = getattr(self._profile.parts[part], mode.yaml_name)
        self.axes = self._axes()
        self._row: FloatArray | None = None

    def with_steps(self, step: float) -> FullScaleRows:
        """The same with other steps of joint targets [rad]."""
        self._limits = self._limits.model_copy(update={"step_limits": (step,) * self.axes})
        return self

    def go_on_after(self, values: FloatArray | None) -> None:
        """Another row than the newest acted last; None: the part holds, the next is a first one."""
        wide = self.mode.is_joint_mode and values is not None
        self._row = values[self._joints] if wide and values is not None else values

    def row(self, wish: FloatArray, now: Moment) -> PartCommand:
        """The next row towards ``wish``, shape ``[axes]``."""
        if self.mode in TARGETS:
            values = self._targets(wish, now)
        elif self.mode is ControlMode.JOINT_VELOCITY:
            values = self._velocities(wish, now)
        elif self.mode in HALVES:
            values = self._halves(wish)
        elif self.mode is ControlMode.CARTESIAN_POSE:
            values = self._pose(wish, now)
        else:
            values = self._scalar(wish)
        self._row = values
        if not self.mode.is_joint_mode:
            frames = getattr(self._limits, "frames", ("",))
            return PartCommand(self.mode, frames[0], values, ())
        wide = np.zeros(self._robot.n_dof)
        wide[self._joints] = values
        return PartCommand(self.mode, "", wide, tuple(self._joints))

    def _axes(self) -> int:
        if self.mode is ControlMode.CARTESIAN_POSE:
            return 6
        return len(self._joints) if self.mode.is_joint_mode else self.mode.width(0)

    def _inwards(self, wish: FloatArray, now: Moment) -> FloatArray:
        """Away from a bound that is near."""
        if not self._turns_back:
            return wish
        joints = [self._robot.joints[index] for index in self._joints]
        found = wish.copy()
        for axis, (joint, index) in enumerate(zip(joints, self._joints, strict=True)):
            if not joint.has_bounds:
                continue
            room = joint.velocity_limit * BOUND_ROOM_S
            room = min(room, 0.3 * (joint.upper - joint.lower))
            if now.positions[index] < joint.lower + room:
                found[axis] = abs(found[axis])
            elif now.positions[index] > joint.upper - room:
                found[axis] = -abs(found[axis])
        return found

    def _targets(self, wish: FloatArray, now: Moment) -> FloatArray:
        steps = np.array(self._limits.step_limits)
        joints = [self._robot.joints[index] for index in self._joints]
        before = self._row
        if before is None:  # a first row may start by the joint's tolerance further away
            before = now.positions[self._joints]
            measured = self._profile.measured
            steps = steps + [measured[joint.name].tolerance or 0.0 for joint in joints]
        lower, upper = (
            np.array([getattr(j, end) if j.has_bounds else free for j in joints])
            for end, free in (("lower", -np.inf), ("upper", np.inf))
        )
        return np.asarray(
            np.clip(before + self._inwards(wish, now) * steps * ROUNDING, lower, upper)
        )

    def _velocities(self, wish: FloatArray, now: Moment) -> FloatArray:
        joints = [self._robot.joints[index] for index in self._joints]
        most = np.array([profile_limits(one, self._profile)[0] for one in joints]) * ROUNDING
        before = np.zeros(len(most)) if self._row is None else self._row
        step = np.array(self._limits.step_limits) * ROUNDING
        return before + np.clip(self._inwards(wish, now) * most - before, -step, step)

    def _halves(self, wish: FloatArray) -> FloatArray:
        before = np.zeros(6) if self._row is None else self._row
        found = np.zeros(6)
        free = getattr(self._limits, "free_axes", range(6))
        for half, name in ((slice(0, 3), "linear"), (slice(3, 6), "angular")):
            mask = np.array([axis in free for axis in range(6)])[half]
            most, step = (
                ROUNDING * _number(self._limits, f"{name}{of}") for of in ("_limit", "_step_limit")
            )
            wanted = np.where(mask, wish[half], 0.0)
            wanted *= most / max(1.0, float(np.sqrt(mask.sum())))
            change = wanted - before[half]
            found[half] = before[half] + change * min(1.0, step / max(_norm(change), 1e-12))
        return found

    def _pose(self, wish: FloatArray, now: Moment) -> FloatArray:
        if self._row is None:
            place, turn = now.tools[self.part]
        else:
            place, turn = self._row[:3], rotation_of(self._row[3:])
        scale = ROUNDING / np.sqrt(3.0)
        shift = wish[:3] * self._limits.linear_step_limit_m * scale
        angles = wish[3:] * self._limits.angular_step_limit_rad * scale
        place = np.clip(place + shift, self._limits.lower_m, self._limits.upper_m)
        return np.concatenate([place, quaternion_of(exponential(angles) @ turn)])

    def _scalar(self, wish: FloatArray) -> FloatArray:
        if self.mode is ControlMode.GRIPPER_POSITION:
            ends = self._limits.lower, self._limits.upper
            return np.array([ends[int(wish[0] > 0.0)]])
        if self.mode is ControlMode.GRIPPER_BINARY:
            return np.array([float(wish[0] > 0.0)])
        return np.sign(wish)


def _norm(vector: FloatArray) -> float:
    return float(np.linalg.norm(vector))


def _number(limits: object, start: str) -> float:
    """The limit of that name, whatever its unit."""
    for unit in ("_m", "_rad", "_m_s", "_rad_s"):
        if hasattr(limits, start + unit):
            return float(getattr(limits, start + unit))
    raise AttributeError(start)
