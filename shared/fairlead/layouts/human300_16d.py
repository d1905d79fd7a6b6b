"""human300_16d: end effector in the base, base in the world, fingers (RoboCasa365)."""

from __future__ import annotations

import numpy as np

from fairlead.layout import Layout, LayoutField, LayoutInputs
from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings


def assemble(at: LayoutInputs) -> FloatArray:
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
    return np.concatenate(
        (
            at.position3("base_frame", "eef_frame"),
            at.quaternion4("base_frame", "eef_frame"),
            at.pose7("world_frame", "base_frame"),
            at.gripper2(),
        )
    )


_WORLD_BASE = ("world_frame", "base_frame")

LAYOUT = Layout(
    content="end effector in the base, base in the world, fingers (RoboCasa365)",
    dim=16,
    assemble=assemble,
    required=("eef_frame", "base_frame", "world_frame", "gripper_qpos_joints"),
    optional=("eef_rotation_frame", "quaternion_convention", "quaternion_signs"),
    example=StateContractBindings(
        eef_frame="grip_site",
        eef_rotation_frame="panda_hand",
        base_frame="base_site",
        world_frame="map",
        gripper_qpos_joints=("panda_finger_joint1", "panda_finger_joint2"),
    ),
    fields=(
        LayoutField("base_to_eef position", "position", 0, ("eef_frame", "base_frame")),
        LayoutField("base_to_eef rotation", "quaternion", 3, ("eef_rotation_frame", "base_frame")),
        LayoutField("world_to_base position", "position", 7, _WORLD_BASE),
        LayoutField("world_to_base rotation", "quaternion", 10, _WORLD_BASE),
        LayoutField("gripper", "gripper", 14, ("gripper_qpos_joints",)),
    ),
)
"""The example: what robosuite's PandaOmron reports, the grip site's place, the hand's rotation."""
