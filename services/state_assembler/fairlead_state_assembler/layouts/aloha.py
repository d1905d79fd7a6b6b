"""aloha: joints of two arms with their grippers (ALOHA)."""

from __future__ import annotations

from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings, bound_joints
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.registry import Transforms, register


@register("aloha")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
    """Assemble the vector: float64, shape ``[14]``.

    ======== =================== ====== ===================================================
    slice    content             unit   source
    ======== =================== ====== ===================================================
    [0:6]    left arm's joints   rad    ``joint_names``; unbound: ``left_waist``,
                                        ``_shoulder``, ``_elbow``, ``_forearm_roll``,
                                        ``_wrist_angle``, ``_wrist_rotate``
    [6]      left gripper        as     ``joint_names``; unbound: ``left_gripper``
                                 joint
    [7:13]   right arm's joints  rad    the same with ``right_``
    [13]     right gripper       as     the same with ``right_``
                                 joint
    ======== =================== ====== ===================================================

    Uses no transforms. A gripper is what its joint measures: nothing is normalised.

    Raises:
        LayoutError: for a joint that is missing.
    """
    return joints.positions(bound_joints("aloha", bindings))


def example_aloha() -> StateContractBindings:
    """A robot with ALOHA's joint names needs none."""
    return StateContractBindings()
