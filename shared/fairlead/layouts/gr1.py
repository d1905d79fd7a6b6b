"""gr1: a name that is known and refused: nothing assembles it yet."""

from __future__ import annotations

from fairlead.layout import Layout

LAYOUT = Layout(
    content="no assembler",
    dim=None,
    assemble=None,
    required=("eef_frame", "base_frame", "world_frame", "gripper_qpos_joints"),
)
"""Without a width and a function."""
