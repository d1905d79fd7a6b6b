"""gripper_pose_8d: end effector in the base, opening of the gripper."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings
from fairlead_state_assembler.bound_frames import BoundFrames
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_vector import gripper_pair
from fairlead_state_assembler.registry import Transforms, register


@register("gripper_pose_8d")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
    """Assemble the vector: float64, shape ``[8]``.

    ======== ======================== ====== ==============================================
    slice    content                  unit   source
    ======== ======================== ====== ==============================================
    [0:3]    end effector's position  m      ``eef_frame`` in ``base_frame``
    [3:7]    end effector's rotation  quat.  ``eef_rotation_frame`` (or ``eef_frame``)
                                             in ``base_frame``
    [7]      opening                  m      first less second of ``gripper_qpos_joints``
    ======== ======================== ====== ==============================================

    Raises:
        LayoutError: for a frame or joint that is missing or too old.
    """
    at = BoundFrames("gripper_pose_8d", bindings, transforms)
    first, second = gripper_pair(bindings.gripper_qpos_joints, joints)
    return np.concatenate(
        (
            at.position3("base_frame", "eef_frame"),
            at.quaternion4("base_frame", "eef_frame"),
            [first - second],
        )
    )


def example_gripper_pose_8d() -> StateContractBindings:
    """robosuite's PandaOmron."""
    return StateContractBindings(
        eef_frame="grip_site",
        base_frame="base_link",
        gripper_qpos_joints=("panda_finger_joint1", "panda_finger_joint2"),
    )
