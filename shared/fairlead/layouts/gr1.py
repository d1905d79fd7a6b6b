"""gr1: a name that is known and refused: nothing assembles it yet."""

from __future__ import annotations

from fairlead.layout import Layout

LAYOUT = Layout(
    content="no assembler",
    dim=None,
    assemble=None,
    required=("eef_frame", "base_frame", "world_frame", "gripper_qpos_joints"),
    optional=("eef_rotation_frame", "quaternion_convention", "quaternion_signs"),
)
"""Without a width and a function."""
