"""Numbers and names that the golden messages are made of: no two that could be swapped unseen."""

from __future__ import annotations

from fairlead.messages import (
    pack_floats,
)

U32_MAX = 2**32 - 1
U64_MAX = 2**64 - 1
TINY = 5e-324  # the smallest denormal
HUGE = 1.7976931348623157e308

ROBOT_HASH = bytes(range(32))
CONFIG_HASH = bytes(range(32, 64))
SKILL_HASH = bytes(range(64, 96))
TRACE = bytes(range(200, 224))

SESSION = 0x1122334455667788
EPOCH = 0x2233445566778899
CLAIM = 0x33445566778899AA
VERDICT = 0x445566778899AABB
GOAL = 0x5566778899AABBCC
STOP = 0x66778899AABBCCDD

JOINTS = (
    "base_x",
    "base_y",
    "base_yaw",
    *(f"panda_joint{n}" for n in range(1, 8)),
    "panda_gripper",
)
PASSIVE = ("panda_finger_joint1", "panda_finger_joint2", "torso_height")


def ramp(count: int, start: float, step: float = 0.125) -> bytes:
    """A float64 block start, start + step, ...: every number of it is distinct."""
    return pack_floats([start + step * k for k in range(count)])
