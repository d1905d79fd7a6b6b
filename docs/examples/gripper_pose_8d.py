"""gripper_pose_8d: end effector in the base, opening of the gripper."""

from __future__ import annotations

import numpy as np

from fairlead import StateContractBindings
from fairlead.layout import Layout, LayoutInputs
from fairlead.messages import FloatArray


def assemble(at: LayoutInputs) -> FloatArray:
    """Assemble the vector: float64, shape ``[8]``.

    ======== ======================== ====== ==============================================
    slice    content                  unit   source
    ======== ======================== ====== ==============================================
    [0:3]    end effector's position  m      ``eef_frame`` in ``base_frame``
    [3:7]    end effector's rotation  quat.  ``eef_rotation_frame`` (or ``eef_frame``)
                                             in ``base_frame``
    [7]      opening                  m      first less second of ``gripper_qpos_joints``
    ======== ======================== ====== ==============================================
    """
    first, second = at.gripper2()
    return np.concatenate(
        (
            at.position3("base_frame", "eef_frame"),
            at.quaternion4("base_frame", "eef_frame"),
            [first - second],
        )
    )


LAYOUT = Layout(
    content="end effector in the base, opening of the gripper",
    dim=8,
    assemble=assemble,
    required=("eef_frame", "base_frame", "gripper_qpos_joints"),
    optional=("eef_rotation_frame", "quaternion_convention", "quaternion_signs"),
    example=StateContractBindings(
        eef_frame="grip_site",
        base_frame="base_link",
        gripper_qpos_joints=("panda_finger_joint1", "panda_finger_joint2"),
    ),
)
