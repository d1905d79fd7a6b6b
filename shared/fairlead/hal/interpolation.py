"""Between setpoints: what a drive is told that is faster than the rows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from fairlead.messages import FloatArray
from fairlead.robot.executed_way import smoothed_changes
from fairlead.robot.interpolation import LATE_PERIODS
from fairlead.robot.manifest import RobotManifest

Way = Callable[[float], FloatArray]
"""Setpoints within one period [rad or m], from place 0 (its start) to 1 (its end)."""


class Interpolator(Protocol):
    """Makes the way of each period from the setpoint at its end.

    Attributes:
        lag_periods: how long after a setpoint that moves steadily the way gets there.
    """

    lag_periods: float

    def restart(self, positions: FloatArray) -> None:
        """Stand still at ``positions``, shape ``[n_dof]``."""

    def advance(self, setpoint: FloatArray) -> Way:
        """The next period's way, towards its setpoint, shape ``[n_dof]``."""


class LinearInterpolator:
    """Straight from setpoint to setpoint, as the gate predicts it.

    Velocity jumps at each setpoint.
    """

    lag_periods = LATE_PERIODS["linear"]

    def restart(self, positions: FloatArray) -> None:
        """As `Interpolator.restart`."""
        self._before = positions.copy()

    def advance(self, setpoint: FloatArray) -> Way:
        """As `Interpolator.advance`."""
        start, self._before = self._before, setpoint.copy()
        way = setpoint - start
        return lambda place: start + way * place


class SplineInterpolator:
    """The uniform cubic B-spline that has the setpoints as its control points, near enough.

    Position is continuous; velocity and acceleration are, where no change of step is more than
    ``most``. Of the newest setpoints (C. de Boor, A Practical Guide to Splines, chapters IX to XI):

    - a position lies in the convex hull of four: no joint is beyond all of them;
    - a velocity in that of their three steps per period: no joint is faster than the fastest;
    - an acceleration in that of their two changes of step per period squared, each up to ``most``;
    - in each period the way is within a sixth of the larger change, up to ``most``, of the straight
      line between the middle two, joint by joint.

    When setpoints stand still, so does the way three periods later, at the setpoint.

    Args:
        most: by joint, the largest change of step that is smoothed [rad or m]; of a larger one the
            rest is a leap of velocity at the setpoint.
    """

    lag_periods = LATE_PERIODS["cubic_b_spline"]

    def __init__(self, most: FloatArray) -> None:
        self._most = most

    def restart(self, positions: FloatArray) -> None:
        """As `Interpolator.restart`."""
        self._setpoints = np.tile(positions, (4, 1))

    def advance(self, setpoint: FloatArray) -> Way:
        """As `Interpolator.advance`."""
        first, start, end, last = np.vstack([self._setpoints[1:], setpoint])
        self._setpoints = np.array([first, start, end, last])
        way = end - start
        before = np.clip(first - start + way, -self._most, self._most) / 6.0
        after = np.clip(last - end - way, -self._most, self._most) / 6.0
        return lambda place: start + way * place + before * (1.0 - place) ** 3 + after * place**3


def interpolator_of(robot: RobotManifest, profile: str) -> Interpolator:
    """What makes the way that the robot's gate file is made for."""
    if robot.interpolation == "linear":
        return LinearInterpolator()
    changes = smoothed_changes(robot, profile)
    return SplineInterpolator(np.array([changes[name] for name in robot.joint_names]))
