"""Body twists become joint commands that undo what the simulator does to them."""

from __future__ import annotations

import re

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.messages import FloatArray
from fairlead_hal_sim.base_frame import BaseMotion, joint_rates, rotation

PIVOT = (-0.21, 0.0)
DEAD_BAND = np.array([0.25, 0.25, 1.0 / 6.0])


def simulated_twist(command: FloatArray, motion: BaseMotion) -> FloatArray:
    """What base_link does: commands turned back, friction lost, slides plus swing."""
    slides = rotation(-motion.turned) @ command[:2]
    rates = np.append(slides, command[2])
    moving = np.sign(rates) * np.maximum(np.abs(rates) - motion.dead_band, 0.0)
    own = rotation(-motion.yaw) @ moving[:2]
    swing = moving[2] * np.array([motion.pivot[1], -motion.pivot[0]])
    return np.array([*(own + swing), moving[2]])


@pytest.mark.parametrize("yaw_at_reset", [0.0, 0.4])
@pytest.mark.parametrize("turned", [0.0, np.pi / 2, np.pi, -1.1])
@pytest.mark.parametrize("twist", [(0.3, 0.0, 0.0), (0.0, 0.3, 0.0), (0.1, -0.2, 0.5)])
def test_the_base_does_what_the_twist_says(
    twist: tuple[float, float, float], turned: float, yaw_at_reset: float
) -> None:
    motion = BaseMotion(yaw_at_reset + turned, turned, PIVOT, DEAD_BAND)
    x, y, yaw_rate = twist
    command = joint_rates(np.array([x, y, 0.0, 0.0, 0.0, yaw_rate]), motion)
    np.testing.assert_allclose(simulated_twist(command, motion), twist, atol=1e-12)


def test_a_zero_twist_gets_no_friction_lift() -> None:
    motion = BaseMotion(0.3, 0.3, PIVOT, DEAD_BAND)
    assert not joint_rates(np.zeros(6), motion).any()


def test_the_largest_twist_that_is_released_can_be_done_at_every_yaw() -> None:
    worst = 0.0
    for yaw, way in np.stack(np.meshgrid(*[np.linspace(0.0, 2 * np.pi, 181)] * 2), -1).reshape(
        -1, 2
    ):
        twist = np.array([0.4 * np.cos(way), 0.4 * np.sin(way), 0.0, 0.0, 0.0, 1.17])
        rates = joint_rates(twist, BaseMotion(yaw, yaw, PIVOT, DEAD_BAND))
        worst = max(worst, float(np.abs(rates[:2]).max()))
    assert 0.98 < worst <= 1.0  # of the slides' 1 m/s


@pytest.mark.parametrize("axis", [2, 3, 4])
def test_an_axis_the_base_cannot_do_is_refused(axis: int) -> None:
    twist = np.zeros(6)
    twist[axis] = 0.1
    text = f"body_twist: expected 0.0 on z, roll and pitch of a planar base, got {twist.tolist()}"
    with pytest.raises(ConfigError, match=f"^{re.escape(text)}$"):
        joint_rates(twist, BaseMotion(0.0, 0.0, PIVOT, DEAD_BAND))
