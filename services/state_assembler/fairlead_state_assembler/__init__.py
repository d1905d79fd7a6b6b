"""State vectors for policies, from joints and transforms.

The names below are the public face; they need no Zenoh.
"""

from fairlead_state_assembler.forward_kinematics import ForwardKinematics
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.local_assembler import LocalAssembler
from fairlead_state_assembler.options import AssemblerOptions
from fairlead_state_assembler.pose_decoding import pose_from
from fairlead_state_assembler.registry import assemble_state
from fairlead_state_assembler.transform_buffer import TransformBuffer

__all__ = [
    "AssemblerOptions",
    "ForwardKinematics",
    "JointPositions",
    "LocalAssembler",
    "TransformBuffer",
    "assemble_state",
    "pose_from",
]
