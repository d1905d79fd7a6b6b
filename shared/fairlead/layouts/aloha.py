"""aloha: joints of two arms with their grippers (ALOHA)."""

from __future__ import annotations

from fairlead.layout import Layout, LayoutInputs
from fairlead.messages import FloatArray


def assemble(at: LayoutInputs) -> FloatArray:
    """Assemble the vector: float64, shape ``[14]``.

    ======== =================== ====== ===================================================
    slice    content             unit   source
    ======== =================== ====== ===================================================
    [0:6]    left arm's joints   rad    ``joint_names``; unbound: ``left_waist``,
                                        ``_shoulder``, ``_elbow``, ``_forearm_roll``,
                                        ``_wrist_angle``, ``_wrist_rotate``
    [6]      left gripper        as     ``joint_names``; unbound: ``left_gripper``
                                 joint
    [7:13]   right arm's joints  rad    the same with ``right_``
    [13]     right gripper       as     the same with ``right_``
                                 joint
    ======== =================== ====== ===================================================

    Uses no transforms. A gripper is what its joint measures: nothing is normalised.

    Raises:
        LayoutError: for a joint that is missing.
    """
    return at.joints()


_JOINTS = ("waist", "shoulder", "elbow", "forearm_roll", "wrist_angle", "wrist_rotate", "gripper")

LAYOUT = Layout(
    content="joints of two arms with their grippers (ALOHA)",
    dim=14,
    assemble=assemble,
    joint_names=tuple(f"{side}_{joint}" for side in ("left", "right") for joint in _JOINTS),
)
"""Unbound it reads the joints its dataset was recorded with."""
