"""libero: joints of one Franka arm, fingers (LIBERO's own baselines)."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings, bound_gripper, bound_joints
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_vector import gripper_pair
from fairlead_state_assembler.registry import Transforms, register


@register("libero")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
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
    return np.concatenate(
        (
            joints.positions(bound_joints("libero", bindings)),
            gripper_pair(bound_gripper("libero", bindings), joints),
        )
    )


def example_libero() -> StateContractBindings:
    """A robot with Franka's joint names needs none."""
    return StateContractBindings()
