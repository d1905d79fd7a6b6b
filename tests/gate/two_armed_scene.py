"""A real gate for the robot with two arms, and one part's rows for it in any mode."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

from bench.equipment.gate_scene import Scene
from fairlead.messages import ActionPart, pack_floats
from fairlead.modes import ControlMode
from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot

ROBOT = load_robot("dual_panda")
BENT = {"joint4": -1.8, "joint6": 1.8}
"""Arm joints that are not at 0, in whose place 0 would be outside the limits."""


def two_armed_scene(state_dir: Path) -> Scene:
    """A gate for the two-armed robot, every part of it claimed."""
    scene = Scene(gate_config(ROBOT.id, "sim"), state_dir, robot=ROBOT.id)
    names = (*scene.hal.joints, *scene.hal.passive)
    scene.hal.positions = np.array([BENT.get(name.split("_", 1)[1], 0.0) for name in names])
    scene.meet_hal()
    scene.arm()
    scene.take_claim(*ROBOT.part_names)
    return scene


def action(part: str, mode: ControlMode, rows: list[np.ndarray], frame: str = "") -> ActionPart:
    """Rows of one part, all of its joints active in a joint mode."""
    joints = [ROBOT.joint_names.index(name) for name in ROBOT.part(part).joints]
    return ActionPart(
        part=ROBOT.part_names.index(part),
        mode=mode,
        frame_id=frame,
        values=pack_floats(np.array(rows)),
        active=tuple(joints) if mode.is_joint_mode else (),
    )


def per_joint(scene: Scene, part: str, mode: ControlMode, first: float) -> ActionPart:
    """Two rows; ``first`` is what the first joint is to do, the others stay as they are."""
    joints = [ROBOT.joint_names.index(name) for name in ROBOT.part(part).joints]
    row = np.zeros(ROBOT.n_dof)
    if mode in (ControlMode.JOINT_POSITION, ControlMode.DEX_HAND_JOINT):
        row[joints] = scene.hal.positions[joints]
    row[joints[0]] += first
    return action(part, mode, [row, row])


def tool_pose(scene: Scene, part: str) -> np.ndarray:
    """Measured pose of the part's tool in base_link: xyz [m], quaternion xyzw. By pinocchio."""
    model = pin.buildModelFromUrdf(str(ROBOT.description_path()))
    data, q = model.createData(), np.zeros(model.nq)
    names = (*scene.hal.joints, *scene.hal.passive)
    for name in list(model.names)[1:]:
        q[model.joints[model.getJointId(name)].idx_q] = scene.hal.positions[names.index(name)]
    pin.framesForwardKinematics(model, data, q)
    tool = ROBOT.end_effector(str(ROBOT.part(part).end_effector)).tool_frame
    return np.array(pin.SE3ToXYZQUAT(data.oMf[model.getFrameId(tool)]))
