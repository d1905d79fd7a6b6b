"""How a drive that is faster than the rows is told to go between them."""

from __future__ import annotations

from typing import Literal

Interpolation = Literal["linear", "cubic_b_spline"]
"""`interpolation` in robot.yaml.

linear: straight from setpoint to setpoint. cubic_b_spline: smooth, a period late, and a little
beside; not on mobile bases. A HAL of one's own does it by
`fairlead.hal.interpolation.interpolator_of`.
"""

LATE_PERIODS: dict[Interpolation, float] = {"linear": 0.0, "cubic_b_spline": 1.0}
"""How long after a setpoint that moves steadily the way gets there."""
ENDS_PERIODS: dict[Interpolation, float] = {"linear": 0.0, "cubic_b_spline": 2.0}
"""How much later than the straight way it is at a last setpoint."""
