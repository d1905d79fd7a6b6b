"""human300_16d: end effector in the base, base in the world, gripper (16 numbers)."""

from __future__ import annotations

import numpy as np

from fairlead.bindings import StateContractBindings
from fairlead.messages import FloatArray
from fairlead_state_assembler.binding_check import bound
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_vector import gripper_pair, pose7, rotation4
from fairlead_state_assembler.registry import Transforms, register


@register("human300_16d")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
    """Assemble the vector: float64, shape ``[16]``.

    ======== ============================ ====== ===========================================
    slice    content                      unit   source
    ======== ============================ ====== ===========================================
    [0:3]    end effector's position      m      ``eef_frame`` in ``base_frame``
    [3:7]    end effector's rotation      quat.  ``eef_rotation_frame`` (or ``eef_frame``)
                                                 in ``base_frame``
    [7:10]   base's position              m      ``base_frame`` in ``world_frame``
    [10:14]  base's rotation              quat.  ``base_frame`` in ``world_frame``
    [14:16]  fingers                      m      ``gripper_qpos_joints``; one joint v
                                                 stands for ``[v, -v]``
    ======== ============================ ====== ===========================================

    Quaternions are in ``quaternion_convention`` order with w >= 0.

    Raises:
        LayoutError: for a frame or joint that is missing or too old.
    """
    base = bound("human300_16d", bindings, "base_frame")
    world = bound("human300_16d", bindings, "world_frame")
    eef = bound("human300_16d", bindings, "eef_frame")
    order = bindings.quaternion_convention
    T_base_eef = transforms.pose(base, eef)
    T_base_eef_rotation = (
        transforms.pose(base, bindings.eef_rotation_frame)
        if bindings.eef_rotation_frame
        else T_base_eef
    )
    return np.concatenate(
        (
            T_base_eef.translation,
            rotation4(T_base_eef_rotation, order),
            pose7(transforms.pose(world, base), order),
            gripper_pair(bindings.gripper_qpos_joints, joints),
        )
    )
