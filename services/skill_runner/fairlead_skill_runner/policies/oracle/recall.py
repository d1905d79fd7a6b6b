"""What the oracle would remember, guessed from one observation alone.

Its own phases go on when the hand is at rest or time has passed, which no single state says. A
policy without memory can learn only what a state shows: where hand and base are, how far the
fingers are open, where the object is. Borders are wider here than in `phases`: whoever learned
this stops short of where it was told to go.
"""

from __future__ import annotations

import numpy as np

from fairlead_skill_runner.policies.oracle.motion import Vector, turn, wrap
from fairlead_skill_runner.policies.oracle.phases import (
    GRIP_M,
    HOVER_M,
    LIFT_M,
    OBJECT_BOTTOM_M,
    REACH_M,
    STAGING_M,
    Memory,
    Phase,
    before_cabinet,
    enter,
    holds,
)
from fairlead_skill_runner.policies.oracle.sight import Sight

HELD_M, FREE_M = 0.064, 0.075
"""Fingers closer than the first have the object, further apart than the second have let it go."""

DOWN_M = 0.010
"""An object so low above the shelf is let go."""

LIFTED_M = OBJECT_BOTTOM_M + GRIP_M + LIFT_M - 0.03
"""A hand as far above the shelf may drive."""

INSIDE = np.array([-0.12, 0.24, 0.25])
"""Of the object in the goal's frame: from x, to x, half the width [m]."""


def recall(sight: Sight, home_yaw: float) -> Memory:
    """The memory of an oracle that came to this sight in the ordinary way."""
    on_shelf = float(sight.goal[2]) + OBJECT_BOTTOM_M
    hand = np.array([sight.eef[0], sight.eef[1], sight.obj[2] + GRIP_M])
    memory = Memory(home_yaw=home_yaw, grasp_height=on_shelf, hand=hand)
    for phase in (Phase.TRANSPORT, _phase(sight, home_yaw)):  # the first says how high to carry
        enter(memory, phase, sight)
    return memory


def _phase(sight: Sight, home_yaw: float) -> Phase:
    held = holds(sight) and sight.opening < HELD_M
    if _inside(sight):
        return _at_the_shelf(sight, held)
    return _carrying(sight) if held else _grasping(sight, home_yaw)


def _at_the_shelf(sight: Sight, held: bool) -> Phase:
    if held and sight.obj[2] - OBJECT_BOTTOM_M - sight.goal[2] > DOWN_M:
        slack = 0.03 if _height(sight) > LIFTED_M else 0.08  # once begun, it is lowered
        ahead, side, yaw = np.abs(_way_in(sight))
        return Phase.LOWER if max(ahead, side, yaw) < slack else Phase.ENTER
    return Phase.RELEASE if holds(sight) and sight.opening < FREE_M else Phase.RETREAT


def _carrying(sight: Sight) -> Phase:
    if _height(sight) < LIFTED_M:
        return Phase.LIFT
    ahead, side, yaw = _way_in(sight)
    slack = 0.03 + 0.2 * max(0.0, STAGING_M - ahead)
    straight = ahead < STAGING_M + 0.03 and max(abs(side), abs(yaw)) < slack
    return Phase.ENTER if straight else Phase.TRANSPORT


def _grasping(sight: Sight, home_yaw: float) -> Phase:
    lateral = float(np.linalg.norm(sight.obj[:2] - sight.eef[:2]))
    height = float(sight.eef[2] - sight.obj[2])
    reach = turn(home_yaw) @ np.array([REACH_M, 0.0])
    away = float(np.linalg.norm(sight.obj_odom - reach - sight.base[:2]))
    turned = abs(wrap(home_yaw - float(sight.base[2])))
    if max(away, turned) > (0.10 if lateral < 0.05 else 0.04):
        return Phase.APPROACH
    if lateral < 0.018 and abs(height - GRIP_M) < 0.014 and sight.opening > 0.02:
        return Phase.GRASP
    near = 0.012 if height > (GRIP_M + HOVER_M) / 2 else 0.018
    return Phase.DESCEND if lateral < near and height < HOVER_M + 0.03 else Phase.ALIGN


def _height(sight: Sight) -> float:
    """Of the hand above the shelf [m]."""
    return float(sight.eef[2] - sight.goal[2])


def _way_in(sight: Sight) -> Vector:
    """To where the base places from: ahead and to the side of the cabinet [m], turn [rad]."""
    offset = before_cabinet(sight, 0.0) - sight.base
    return np.append(turn(-sight.goal_yaw) @ offset[:2], wrap(float(offset[2])))


def _inside(sight: Sight) -> bool:
    offset = turn(float(sight.base[2]) - sight.goal_yaw) @ (sight.obj - sight.goal)[:2]
    first, last, side = INSIDE
    return bool(first < offset[0] < last and abs(offset[1]) < side)
