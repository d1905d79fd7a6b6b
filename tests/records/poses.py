"""The record's own bindings, and transforms that fill them."""

from __future__ import annotations

from typing import Any

from fairlead_state_assembler import TransformBuffer, pose_from

RECORDS_BINDINGS: dict[str, Any] = {
    "eef_frame": "panda_hand_tcp",
    "base_frame": "base_link",
    "world_frame": "odom",
    "gripper_qpos_joints": ["panda_gripper"],
    "quaternion_convention": "xyzw",
}
RECORDED: dict[str, Any] = {"layout": "human300_16d", "dim": 16, "bindings": RECORDS_BINDINGS}
"""The record's own manifest."""

HAND_TURNED = (0.0, 0.0, 0.6, 0.8)
BASE_TURNED = (0.0, 0.6, 0.0, 0.8)


def transforms(tick: int = 1) -> TransformBuffer:
    """The hand at (0.5, 0.1, 1.2) in the base, the base at (2, 1, 0) in the world."""
    buffer = TransformBuffer()
    tcp = pose_from("panda_hand_tcp", [0.5, 0.1, 1.2], HAND_TURNED)
    base = pose_from("base_link", [2.0, 1.0, 0.0], BASE_TURNED)
    buffer.add("base_link", "panda_hand_tcp", tcp, tick, is_static=False)
    buffer.add("odom", "base_link", base, tick, is_static=False)
    return buffer
