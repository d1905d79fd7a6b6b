"""How a mobile base's commands become motion, and the inverse for body twists.

robosuite turns the commanded x, y by ``-turned`` (the yaw since reset) before it drives
the two slide joints, whose axes never turn. At reset that is the base's own frame; after
a quarter turn it is not. Checkpoints were trained with this, so joint_velocity passes
through unchanged; `joint_rates` undoes it for twists, which mean what they say.

Each joint also has dry friction: a velocity servo with gain ``kv`` behind a friction
``f`` moves at the commanded rate minus ``f / kv``, so twists are lifted by that much.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray

STILL = 1e-6
"""Joint rates below this [m/s or rad/s] are meant as zero and get no friction lift."""


@dataclass(frozen=True)
class BaseMotion:
    """The base's situation at one tick.

    yaw: angle of the base in the frame of its slide joints [rad].
    turned: yaw since reset, by which the simulator turns commands back [rad].
    pivot: position of the yaw axis in base_link, x and y [m].
    dead_band: rate lost to friction per joint x, y, yaw [m/s, m/s, rad/s].
    """

    yaw: float
    turned: float
    pivot: tuple[float, float]
    dead_band: FloatArray


def rotation(angle: float) -> FloatArray:
    """Plane rotation by ``angle`` [rad], shape ``[2, 2]``."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def joint_rates(twist: FloatArray, motion: BaseMotion) -> FloatArray:
    """Commands x, y, yaw [m/s, m/s, rad/s] that move base_link with ``twist``.

    Args:
        twist: xyz [m/s], xyz [rad/s] of base_link's origin, in base_link.

    Raises:
        ConfigError: if the twist has an axis a planar base cannot do.
    """
    if np.any(twist[[2, 3, 4]] != 0.0):
        raise ConfigError(
            expected("body_twist", "0.0 on z, roll and pitch of a planar base", twist.tolist())
        )
    yaw_rate = twist[5]
    # The slides carry the yaw axis; base_link's origin also swings around it.
    swing = yaw_rate * np.array([motion.pivot[1], -motion.pivot[0]])
    slides = rotation(motion.yaw) @ (twist[:2] - swing)
    rates = np.append(slides, yaw_rate)
    lifted = rates + np.where(np.abs(rates) > STILL, np.sign(rates), 0.0) * motion.dead_band
    return np.append(rotation(motion.turned) @ lifted[:2], lifted[2])
