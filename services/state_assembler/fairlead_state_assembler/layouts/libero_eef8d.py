"""libero_eef8d: end effector in the world with axis-angle, fingers (LIBERO)."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings
from fairlead_state_assembler.bound_frames import BoundFrames
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_vector import gripper_pair
from fairlead_state_assembler.registry import Transforms, register


@register("libero_eef8d")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
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
    at = BoundFrames("libero_eef8d", bindings, transforms)
    return np.concatenate(
        (
            at.position3("world_frame", "eef_frame"),
            at.axis_angle3("world_frame", "eef_frame"),
            gripper_pair(bindings.gripper_qpos_joints, joints),
        )
    )


def example_libero_eef8d() -> StateContractBindings:
    """The numbers of robosuite, whose sign keeps x positive while the hand points down.

    With w >= 0 the vector would jump to its opposite there, in the middle of the work.
    """
    return StateContractBindings(
        eef_frame="grip_site",
        eef_rotation_frame="panda_hand",
        gripper_qpos_joints=("panda_finger_joint1", "panda_finger_joint2"),
        quaternion_signs={"eef_frame": "+x"},
    )
