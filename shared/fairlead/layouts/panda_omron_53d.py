"""panda_omron_53d: the twelve state inputs of GR00T's robocasa_panda_omron, in its order."""

from __future__ import annotations

import numpy as np

from fairlead.layout import Layout, LayoutField, LayoutInputs
from fairlead.layouts import human300_16d
from fairlead.messages import FloatArray


def assemble(at: LayoutInputs) -> FloatArray:
    """Assemble the vector: float64, shape ``[53]``.

    ======== ======================== ====== ==============================================
    slice    content                  unit   source
    ======== ======================== ====== ==============================================
    [0:2]    fingers                  m      ``gripper_qpos_joints``
    [2:5]    base's position          m      ``base_frame`` in ``world_frame``
    [5:9]    base's rotation          quat.  ``base_frame`` in ``world_frame``
    [9:12]   end effector's position  m      ``eef_frame`` in ``base_frame``
    [12:16]  end effector's rotation  quat.  ``eef_rotation_frame`` in ``base_frame``
    [16:18]  fingers' velocities      m/s    ``gripper_qpos_joints``
    [18:21]  end effector's position  m      ``eef_frame`` in ``world_frame``
    [21:25]  end effector's rotation  quat.  ``eef_rotation_frame`` in ``world_frame``, its
                                             x never negative, as robosuite has it
    [25:32]  arm joints               rad    ``joint_names``
    [32:39]  their cosines            1      likewise
    [39:46]  their sines              1      likewise
    [46:53]  their velocities         rad/s  likewise
    ======== ======================== ====== ==============================================

    Raises:
        LayoutError: for a frame or joint that is missing or too old.
    """
    joints = at.joints()
    return np.concatenate(
        (
            at.gripper2(),
            at.pose7("world_frame", "base_frame"),
            at.position3("base_frame", "eef_frame"),
            at.quaternion4("base_frame", "eef_frame"),
            at.gripper_velocities2(),
            at.position3("world_frame", "eef_frame"),
            at.quaternion4("world_frame", "eef_frame", "+x"),
            joints,
            np.cos(joints),
            np.sin(joints),
            at.joint_velocities(),
        )
    )


_BASE, _EEF = ("world_frame", "base_frame"), ("eef_frame", "base_frame")
_JOINTS, _FINGERS = ("joint_names",), ("gripper_qpos_joints",)
_ROTATION = "eef_rotation_frame"

LAYOUT = Layout(
    content="state inputs of GR00T's robocasa_panda_omron: poses, fingers, arm joints, velocities",
    dim=53,
    assemble=assemble,
    required=(*human300_16d.LAYOUT.required,),
    joint_names=tuple(f"panda_joint{number}" for number in range(1, 8)),
    example=human300_16d.LAYOUT.example,
    fields=(
        LayoutField("gripper", "gripper", 0, _FINGERS),
        LayoutField("world_to_base position", "position", 2, _BASE),
        LayoutField("world_to_base rotation", "quaternion", 5, _BASE),
        LayoutField("base_to_eef position", "position", 9, _EEF),
        LayoutField("base_to_eef rotation", "quaternion", 12, (_ROTATION, "base_frame")),
        LayoutField("gripper velocities", "gripper velocities", 16, _FINGERS),
        LayoutField("world_to_eef position", "position", 18, ("eef_frame", "world_frame")),
        LayoutField("world_to_eef rotation", "quaternion", 21, (_ROTATION, "world_frame")),
        LayoutField("arm joints", "joints", 25, _JOINTS),
        LayoutField("arm joints' cosines", "ratios", 32, _JOINTS),
        LayoutField("arm joints' sines", "ratios", 39, _JOINTS),
        LayoutField("arm joints' velocities", "joint velocities", 46, _JOINTS),
    ),
)
"""Unbound it reads Franka's own joints. The rest is what robosuite's PandaOmron reports."""
