"""Between setpoints: what a drive is told that is faster than the rows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, Protocol

import numpy as np

from fairlead.messages import FloatArray

Interpolation = Literal["linear", "cubic_b_spline"]
"""How setpoints of whole periods become those of a faster drive."""

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

    lag_periods = 0.0

    def restart(self, positions: FloatArray) -> None:
        """As `Interpolator.restart`."""
        self._before = positions.copy()

    def advance(self, setpoint: FloatArray) -> Way:
        """As `Interpolator.advance`."""
        start, self._before = self._before, setpoint.copy()
        way = setpoint - start
        return lambda place: start + way * place


class SplineInterpolator:
    """The uniform cubic B-spline that has the setpoints as its control points.

    Position, velocity and acceleration are continuous. Of the newest setpoints (C. de Boor, A
    Practical Guide to Splines, chapters IX to XI):

    - a position lies in the convex hull of four: no joint is beyond all of them;
    - a velocity in that of their three steps per period: no joint is faster than the fastest;
    - an acceleration in that of their two changes of step per period squared;
    - in each period the way is within a sixth of the larger change of step of the straight line
      between the middle two, joint by joint.

    When setpoints stand still, so does the way three periods later, at the setpoint.
    """

    lag_periods = 1.0

    def restart(self, positions: FloatArray) -> None:
        """As `Interpolator.restart`."""
        self._setpoints = np.tile(positions, (4, 1))

    def advance(self, setpoint: FloatArray) -> Way:
        """As `Interpolator.advance`."""
        control = self._setpoints = np.vstack([self._setpoints[1:], setpoint])
        return lambda place: _shares(place) @ control


def _shares(place: float) -> FloatArray:
    """Of the four control points at a place in their span; they are positive and add up to 1."""
    rest = 1.0 - place
    return (
        np.array(
            [
                rest**3,
                3.0 * place**3 - 6.0 * place**2 + 4.0,
                3.0 * rest**3 - 6.0 * rest**2 + 4.0,
                place**3,
            ]
        )
        / 6.0
    )


INTERPOLATORS: dict[Interpolation, type[Interpolator]] = {
    "linear": LinearInterpolator,
    "cubic_b_spline": SplineInterpolator,
}
