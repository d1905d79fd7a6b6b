"""How far and how fast setpoints may move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.profile_limits import profile_limits

TOOL_SHARE = 0.95
"""Of its speed limit, at which a tool's motion moves a joint: its servo is up to 2 % faster."""
LEAD_PERIODS = 2.0
"""Periods of full speed by which a moving setpoint may lead its joint."""


class SetpointLimits:
    """Position limits, speeds and the lead of a robot's commanded joints.

    Attributes:
        lower, upper: position limits [rad or m], infinite for a joint without.
        reach: farthest way in one period [rad or m].
        slowing: how joints slow down [rad/s^2 or m/s^2], as the gate predicts it.
    """

    def __init__(self, robot: RobotManifest, profile: str = "") -> None:
        bounded = [joint if joint.has_bounds else None for joint in robot.joints]
        self.lower = np.array([joint.lower if joint else -np.inf for joint in bounded])
        self.upper = np.array([joint.upper if joint else np.inf for joint in bounded])
        speed = np.array([joint.velocity_limit for joint in robot.joints])
        self.slowing = np.array([joint.acceleration_limit for joint in robot.joints])
        if profile:
            safety = robot.profile(profile)
            speed, self.slowing = np.array(
                [profile_limits(joint, safety)[:2] for joint in robot.joints]
            ).T
        self.reach = speed * robot.tick_period_ns * 1e-9

    def ends(
        self, joints: Sequence[int], setpoints: FloatArray, measured: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Where the setpoints of ``joints`` may go, both ways: as far as they are, at least.

        Args:
            setpoints, measured: of these joints, now.
        """
        own = list(joints)
        lead = LEAD_PERIODS * self.reach[own]
        # A setpoint that leads by more already (it was a position command) may only come back.
        lowest, highest = np.minimum(measured - lead, setpoints), measured + lead
        highest = np.maximum(highest, setpoints)
        # One outside the position limits may only come back, and step by
        # step: limits that left it out would pull it in at once.
        lower = np.minimum(self.lower[own], setpoints)
        upper = np.maximum(self.upper[own], setpoints)
        return np.clip(lowest, lower, upper), np.clip(highest, lower, upper)

    def lead_less(
        self, joints: Sequence[int], setpoints: FloatArray, measured: FloatArray
    ) -> FloatArray:
        """These setpoints, leading by no more than one that moves may."""
        lead = LEAD_PERIODS * self.reach[list(joints)]
        return np.clip(setpoints, measured - lead, measured + lead)

    def step_scale(
        self, joints: Sequence[int], steps: FloatArray, setpoints: FloatArray, measured: FloatArray
    ) -> float:
        """How much of these steps every joint can do in one period: 1.0, or less for all."""
        lowest, highest = self.ends(joints, setpoints, measured)
        reach, moving = TOOL_SHARE * self.reach[list(joints)], steps != 0.0
        most = np.minimum(highest - setpoints, reach)
        least = np.maximum(lowest - setpoints, -reach)
        possible = np.where(steps > 0.0, most, least)[moving] / steps[moving]
        return float(np.clip(np.min(possible, initial=1.0), 0.0, 1.0))
