"""Rows for a robot that nobody judges: small shares of its limits, towards the middle of ranges."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.safety_profile import profile_limits
from fairlead_tools.conformance.plan import Rows
from fairlead_tools.measure.driven_robot import Moment
from fairlead_tools.measure.rows import TARGETS, FullScaleRows

OUT_ROWS = 5
"""Rows of each way of an axis."""
MOVING_ROWS = 14
"""So many rows of a long chunk move: those after them keep a robot that does not hold in place."""
CLEAR = 2.0
"""A row's step, in dead bands, where those are larger than the share of full scale."""


class SmallRows:
    """What the parts of one robot are told, in one safety profile.

    Args:
        share: of full scale.
        modes: by part, those that both the robot's file and the HAL have.
    """

    def __init__(
        self,
        robot: RobotManifest,
        profile: str,
        share: float,
        modes: Mapping[str, Sequence[ControlMode]],
    ) -> None:
        self.robot, self.profile_name, self.share, self.modes = robot, profile, share, modes
        self.profile = robot.profile(profile)
        self.period_s = robot.tick_period_ns * 1e-9
        measured = [self.profile.measured[name] for name in robot.measured_joint_names]
        self.dead = np.array([one.dead_band_per_tick or 0.0 for one in measured])
        self._way = 1.0

    def joints_of(self, part: str) -> list[int]:
        """Wire indices of a part's joints."""
        return [self.robot.joint_names.index(name) for name in self.robot.part(part).joints]

    def limits(self, part: str, mode: ControlMode) -> Any:
        """What the profile declares of a mode."""
        return getattr(self.profile.parts[part], mode.yaml_name)

    def rows(self, part: str, mode: ControlMode, now: Moment) -> FullScaleRows:
        """Rows from rest; targets from where the joints are."""
        rows = FullScaleRows(self.robot, part, mode, turns_back=False, profile=self.profile_name)
        rows.go_on_after(now.positions[: self.robot.n_dof] if mode in TARGETS else None)
        return rows

    def pace(self, part: str, mode: ControlMode, axis: int) -> float:
        """The share of full scale that an axis gets: more than its joints do not notice."""
        if not mode.is_joint_mode:
            return self.share
        index = self.joints_of(part)[axis]
        full = self.full_step(part, mode, axis)
        most, wanted = 1.0, self.share
        if mode in TARGETS:
            most = min(1.0, self._speed(index) * self.period_s / full)
            wanted = max(wanted, CLEAR * 2 * self.dead[index] / (OUT_ROWS * full))
        else:
            wanted = max(wanted, CLEAR * self.dead[index] / full)
        return float(min(most, wanted))

    def full_step(self, part: str, mode: ControlMode, axis: int) -> float:
        """What a joint is told most in one period [rad or m]."""
        if mode in TARGETS:
            return float(self.limits(part, mode).step_limits[axis])
        return self._speed(self.joints_of(part)[axis]) * self.period_s

    def _speed(self, index: int) -> float:
        return profile_limits(self.robot.joints[index], self.profile)[0]

    def mid_way(self, index: int, position: float) -> float:
        """The way to the middle of a joint's range; forth and back where there is none."""
        joint = self.robot.joints[index]
        if not joint.has_bounds:
            return 1.0
        return 1.0 if position < 0.5 * (joint.lower + joint.upper) else -1.0

    def first_modes(self) -> dict[str, ControlMode]:
        """For each part whose hold stands still, the first mode that moves it."""
        found: dict[str, ControlMode] = {}
        for part in self.robot.parts:
            moving = [m for m in self.modes[part.name] if m is not ControlMode.COMPOSITE_MODE]
            if part.joints and part.hold != "keep_command" and moving:
                gentle = [m for m in moving if not m.is_gripper_mode]
                found[part.name] = (gentle or moving)[0]
        return found

    def moving_rows(self, count: int) -> Callable[[Moment], Rows]:
        """Every part that a hold stops on its way, each call the other way."""
        self._way = -self._way
        way = self._way

        def make(now: Moment) -> Rows:
            makers, wishes = {}, {}
            for part, mode in self.first_modes().items():
                makers[part] = self.rows(part, mode, now)
                wishes[part] = self._wish(part, mode, now, makers[part].axes, way)
            return [
                {
                    part: one.row(wishes[part] * float(number < MOVING_ROWS), now)
                    for part, one in makers.items()
                }
                for number in range(count)
            ]

        return make

    def worst(self) -> str:
        """How fast and far a joint is told to go at most, in words."""
        found = [
            (self.pace(part, mode, axis) * self.full_step(part, mode, axis), index)
            for part, mode in self.first_modes().items()
            if mode.is_joint_mode
            for axis, index in enumerate(self.joints_of(part))
        ]
        if not found:
            return f"{100 * self.share:.0f} % of full scale"
        step, index = max(found)
        joint = self.robot.joints[index]
        speed, way = step / self.period_s, step * MOVING_ROWS
        return f"{joint.name} by up to {way:.2g} {joint.unit} at {speed:.2g} {joint.unit}/s"

    def _wish(self, part: str, mode: ControlMode, now: Moment, axes: int, way: float) -> FloatArray:
        wish = np.zeros(axes)
        if mode.is_joint_mode:
            for axis, index in enumerate(self.joints_of(part)):
                inwards = self.mid_way(index, float(now.positions[index]))
                bounded = mode in TARGETS and self.robot.joints[index].has_bounds
                wish[axis] = self.pace(part, mode, axis) * (inwards if bounded else way)
        elif mode is ControlMode.BODY_TWIST:
            wish[0] = self.share * way
        else:
            wish[2] = self.share * way
        return wish
