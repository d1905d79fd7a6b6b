"""libero: joints of one Franka arm, fingers (LIBERO's own baselines)."""

from __future__ import annotations

import numpy as np

from fairlead.layout import Layout, LayoutField, LayoutInputs
from fairlead.messages import FloatArray


def assemble(at: LayoutInputs) -> FloatArray:
    """Assemble the vector: float64, shape ``[9]``.

    ======== ================ ====== ======================================================
    slice    content          unit   source
    ======== ================ ====== ======================================================
    [0:7]    arm joints       rad    ``joint_names``, from the base to the hand; unbound:
                                     ``panda_joint1`` to ``panda_joint7``
    [7:9]    fingers          m      ``gripper_qpos_joints``, one v is ``[v, -v]``;
                                     unbound: ``panda_finger_joint1``, ``..2``
    ======== ================ ====== ======================================================

    Uses no transforms.

    Raises:
        LayoutError: for a joint that is missing.
    """
    return np.concatenate((at.joints(), at.gripper2()))


LAYOUT = Layout(
    content="joints of one Franka arm, fingers (LIBERO's own baselines)",
    dim=9,
    assemble=assemble,
    joint_names=tuple(f"panda_joint{number}" for number in range(1, 8)),
    gripper_qpos_joints=("panda_finger_joint1", "panda_finger_joint2"),
    fields=(
        LayoutField("arm joints", "joints", 0, ("joint_names",)),
        LayoutField("gripper", "gripper", 7, ("gripper_qpos_joints",)),
    ),
)
"""Unbound it reads the joints its dataset was recorded with, Franka's own."""
