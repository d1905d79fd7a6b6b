"""How a drive that is faster than the rows is told to go between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from fairlead.robot.manifest import RobotManifest

Interpolation = Literal["linear", "cubic_b_spline"]
"""linear: straight from setpoint to setpoint. cubic_b_spline: smooth, late, and a little beside."""

LATE_PERIODS: dict[Interpolation, float] = {"linear": 0.0, "cubic_b_spline": 1.0}
"""How long after a setpoint that moves steadily the way gets there."""
ENDS_PERIODS: dict[Interpolation, float] = {"linear": 0.0, "cubic_b_spline": 2.0}
"""How much later than the straight way it is at a last setpoint."""


def smoothed_changes(robot: RobotManifest, profile: str) -> dict[str, float]:
    """By commanded joint, up to which change of step from row to row the way is smooth.

    That of the joint's acceleration limit in the profile over a period [rad or m]; of a larger
    change the rest stays a leap of velocity, as it is without interpolation. The way leaves the
    straight one by a sixth of it at most.
    """
    from fairlead.robot.profile_limits import profile_limits  # imports the manifest's modules

    safety, period_s = robot.profile(profile), robot.tick_period_ns * 1e-9
    return {j.name: profile_limits(j, safety)[1] * period_s**2 for j in robot.joints}
