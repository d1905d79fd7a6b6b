"""panda_omron_53d: the twelve state inputs of GR00T's robocasa_panda_omron."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fairlead.layout import LayoutField, LayoutInputs
from fairlead.layouts import human300_16d
from fairlead.messages import FloatArray


def assemble(at: LayoutInputs) -> FloatArray:
    """Assemble the vector: float64, shape ``[53]``.

    ======== ============================ ====== =====================================
    slice    content                      unit   source
    ======== ============================ ====== =====================================
    [0:16]   fingers, effector, base      m, 1   as in ``human300_16d``, fingers first
    [16:18]  fingers' velocities          m/s    ``gripper_qpos_joints``
    [18:25]  end effector's pose          m, 1   ``eef_frame`` in ``world_frame``
    [25:46]  arm, its cosines and sines   rad, 1 ``joint_names``
    [46:53]  the arm's velocities         rad/s  likewise
    ======== ============================ ====== =====================================

    Raises:
        LayoutError: for a frame or joint that is missing or too old.
    """
    robot, joints = human300_16d.assemble(at), at.joints()
    return np.concatenate(
        (
            np.roll(robot, 2),
            at.gripper_velocities2(),
            at.position3("world_frame", "eef_frame"),
            at.driven_quaternion4("eef_frame", "+x"),  # x > 0 while the hand points down
            joints,
            np.cos(joints),
            np.sin(joints),
            at.joint_velocities(),
        )
    )


_BASE, _EEF = ("world_frame", "base_frame"), ("eef_frame", "base_frame")
_JOINTS, _FINGERS, _ROTATION = ("joint_names",), ("gripper_qpos_joints",), "eef_rotation_frame"

LAYOUT = replace(
    human300_16d.LAYOUT,
    content="state inputs of GR00T's robocasa_panda_omron: poses, fingers, arm joints, velocities",
    dim=53,
    assemble=assemble,
    joint_names=tuple(f"panda_joint{number}" for number in range(1, 8)),
    fields=(
        LayoutField("gripper", "gripper", 0, _FINGERS),
        LayoutField("world_to_base position", "position", 9, _BASE),
        LayoutField("world_to_base rotation", "quaternion", 12, _BASE),
        LayoutField("base_to_eef position", "position", 2, _EEF),
        LayoutField("base_to_eef rotation", "quaternion", 5, (_ROTATION, "base_frame")),
        LayoutField("gripper velocities", "gripper velocities", 16, _FINGERS),
        LayoutField("world_to_eef position", "position", 18, ("eef_frame", "world_frame")),
        LayoutField("world_to_eef rotation", "quaternion", 21, (_ROTATION, "world_frame")),
        LayoutField("arm joints", "joints", 25, _JOINTS),
        LayoutField("arm joints' cosines", "ratios", 32, _JOINTS),
        LayoutField("arm joints' sines", "ratios", 39, _JOINTS),
        LayoutField("arm joints' velocities", "joint velocities", 46, _JOINTS),
    ),
)
"""As robosuite's PandaOmron says it; signs while the hand is down, the base within half a turn."""
