"""One state vector without Zenoh, services or a simulator."""

import numpy as np

from fairlead import StateContractBindings
from fairlead_state_assembler import JointPositions, TransformBuffer, assemble_state, pose_from

bindings = StateContractBindings(
    eef_frame="panda_hand_tcp",
    base_frame="base_link",
    world_frame="odom",
    gripper_qpos_joints=("panda_gripper",),
)
tick = 7
buffer = TransformBuffer()
T_odom_base = pose_from("base_link", [2.0, 0.0, 0.0], [0.0, 0.0, 0.6, 0.8])
T_base_tcp = pose_from("panda_hand_tcp", [0.5, 0.0, 1.1], [1.0, 0.0, 0.0, 0.0])
buffer.add("odom", "base_link", T_odom_base, tick, is_static=False)
buffer.add("base_link", "panda_hand_tcp", T_base_tcp, tick, is_static=False)
joints = JointPositions.named(["panda_gripper"], np.array([0.03]))

state = assemble_state("human300_16d", bindings, joints, buffer.at(tick))
print(state.round(3).tolist())
