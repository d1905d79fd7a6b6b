"""libero_eef8d: end effector in the world with axis-angle, fingers (LIBERO)."""

from __future__ import annotations

import numpy as np

from fairlead.layout import Layout, LayoutField, LayoutInputs
from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings


def assemble(at: LayoutInputs) -> FloatArray:
    """Assemble the vector: float64, shape ``[8]``.

    ======== ======================== ====== ==============================================
    slice    content                  unit   source
    ======== ======================== ====== ==============================================
    [0:3]    end effector's position  m      ``eef_frame`` in ``world_frame``
    [3:6]    end effector's rotation  rad    ``eef_rotation_frame`` (or ``eef_frame``)
                                             in ``world_frame``, unit axis times angle
    [6:8]    fingers                  m      ``gripper_qpos_joints``; one v is ``[v, -v]``
    ======== ======================== ====== ==============================================

    Raises:
        LayoutError: for a frame or joint that is missing or too old.
    """
    return np.concatenate(
        (
            at.position3("world_frame", "eef_frame"),
            at.axis_angle3("world_frame", "eef_frame"),
            at.gripper2(),
        )
    )


_ROTATION = ("eef_rotation_frame", "world_frame")

LAYOUT = Layout(
    content="end effector in the world with axis-angle, fingers (LIBERO)",
    dim=8,
    assemble=assemble,
    required=("eef_frame", "world_frame", "gripper_qpos_joints"),
    optional=("eef_rotation_frame", "quaternion_signs"),
    example=StateContractBindings(
        eef_frame="grip_site",
        eef_rotation_frame="panda_hand",
        gripper_qpos_joints=("panda_finger_joint1", "panda_finger_joint2"),
        quaternion_signs={"eef_frame": "+x"},
    ),
    fields=(
        LayoutField("world_to_eef position", "position", 0, ("eef_frame", "world_frame")),
        LayoutField("world_to_eef rotation", "axis-angle", 3, _ROTATION),
        LayoutField("gripper", "gripper", 6, ("gripper_qpos_joints",)),
    ),
)
"""The example: the numbers of robosuite, whose sign keeps x positive while the hand points down.

With w >= 0 the vector would jump to its opposite there, in the middle of the work. LIBERO's base
stands at yaw 0: on one that turns, world_frame is to be a frame of the base.
"""
