"""human300_16d: end effector in the base, base in the world, fingers (RoboCasa365)."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings
from fairlead_state_assembler.bound_frames import BoundFrames
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_vector import gripper_pair
from fairlead_state_assembler.registry import Transforms, register


@register("human300_16d")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
    """Assemble the vector: float64, shape ``[16]``.

    ======== ======================== ====== ==============================================
    slice    content                  unit   source
    ======== ======================== ====== ==============================================
    [0:3]    end effector's position  m      ``eef_frame`` in ``base_frame``
    [3:7]    end effector's rotation  quat.  ``eef_rotation_frame`` (or ``eef_frame``)
                                             in ``base_frame``
    [7:10]   base's position          m      ``base_frame`` in ``world_frame``
    [10:14]  base's rotation          quat.  ``base_frame`` in ``world_frame``
    [14:16]  fingers                  m      ``gripper_qpos_joints``; one v is ``[v, -v]``
    ======== ======================== ====== ==============================================

    Raises:
        LayoutError: for a frame or joint that is missing or too old.
    """
    at = BoundFrames("human300_16d", bindings, transforms)
    return np.concatenate(
        (
            at.position3("base_frame", "eef_frame"),
            at.quaternion4("base_frame", "eef_frame"),
            at.pose7("world_frame", "base_frame"),
            gripper_pair(bindings.gripper_qpos_joints, joints),
        )
    )


def example_human300_16d() -> StateContractBindings:
    """What robosuite's PandaOmron reports: the grip site's place, the hand's rotation."""
    return StateContractBindings(
        eef_frame="grip_site",
        eef_rotation_frame="panda_hand",
        base_frame="base_site",
        world_frame="map",
        gripper_qpos_joints=("panda_finger_joint1", "panda_finger_joint2"),
    )
