"""Joints without end stops: link poses and layouts as MuJoCo's own kinematics has them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest

from fairlead.layouts.libero_eef8d import LAYOUT
from fairlead.messages import FloatArray
from fairlead.paths import ROBOTS_VARIABLE, robot_dir
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_state_assembler import (
    ForwardKinematics,
    JointPositions,
    TransformBuffer,
    assemble_state,
)

CONTINUOUS = ("panda_joint1", "panda_joint5", "panda_joint7")
OBLIQUE = ("0 0 1", "0.6 0 0.8")
"""Axis of joint 5 in both files: not every continuous joint turns about x, y or z."""


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RobotManifest:
    """The Panda with three joints that turn without end, one about an oblique axis."""
    folder = tmp_path / "turner"
    shutil.copytree(robot_dir("panda"), folder)
    text = (folder / "robot.yaml").read_text()
    (folder / "robot.yaml").write_text(re.sub(r"^id: panda$", "id: turner", text, flags=re.M))
    description = (folder / "panda.urdf").read_text()
    for name in CONTINUOUS:
        description = description.replace(
            f'<joint name="{name}" type="revolute">', f'<joint name="{name}" type="continuous">'
        )
    head, tail = description.split('<joint name="panda_joint5"')
    straight, oblique = (f'<axis xyz="{axis}"/>' for axis in OBLIQUE)
    tail = tail.replace(straight, oblique, 1)
    (folder / "panda.urdf").write_text(f'{head}<joint name="panda_joint5"{tail}')
    model = (folder / "panda.xml").read_text()
    joint = '<joint name="panda_joint5" class="arm"'
    assert joint in model
    (folder / "panda.xml").write_text(model.replace(joint, f'{joint} axis="{OBLIQUE[1]}"'))
    monkeypatch.setenv(ROBOTS_VARIABLE, str(tmp_path))
    return load_robot("turner")


def simulated(robot: RobotManifest, positions: FloatArray) -> dict[str, FloatArray]:
    """T_base_link of every link that is a body in the model: shape [4, 4]."""
    model = mujoco.MjModel.from_xml_path(str(robot.description_path().with_name("panda.xml")))
    data = mujoco.MjData(model)
    for name, value in zip(robot.measured_joint_names, positions, strict=True):
        if name != "panda_gripper":
            data.joint(name).qpos[0] = value
    mujoco.mj_kinematics(model, data)
    poses = {}
    for frame in ForwardKinematics(robot).frames:
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, frame)
        if index >= 0:
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = data.xmat[index].reshape(3, 3), data.xpos[index]
            poses[frame] = pose
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = (
        data.body("base_link").xmat.reshape(3, 3),
        data.body("base_link").xpos,
    )
    inverse = np.linalg.inv(base)
    return {frame: inverse @ pose for frame, pose in poses.items()}


@pytest.mark.parametrize("turns", [0.0, 1.0, -3.0])
def test_links_behind_continuous_joints_are_where_the_simulator_has_them(
    robot: RobotManifest, turns: float
) -> None:
    rng = np.random.default_rng(5)
    positions = rng.uniform(-2.0, 2.0, len(robot.measured_joint_names))
    for name in CONTINUOUS:
        positions[robot.measured_joint_names.index(name)] += 2.0 * np.pi * turns + 2.5
    positions[-2:] = 0.01, -0.01
    kinematics, wanted = ForwardKinematics(robot), simulated(robot, positions)
    found = kinematics.poses(positions)
    assert len(wanted) >= 10
    for frame, pose in wanted.items():
        assert np.allclose(found[kinematics.frames[frame]].homogeneous, pose, atol=1e-6), frame


def test_layouts_rotation_is_the_simulators(robot: RobotManifest) -> None:
    positions = np.array([0.3, -0.5, 0.2, -2.0, 4.0, 1.6, 5.0, 0.02, 0.01, -0.01])
    kinematics, buffer = ForwardKinematics(robot), TransformBuffer()
    buffer.add_links("base_link", kinematics.frames, kinematics.poses(positions), 1)
    bindings = LAYOUT.example.model_copy(
        update={"eef_frame": "panda_hand", "world_frame": "base_link"}
    )
    joints = JointPositions.named(robot.measured_joint_names, positions)
    values = assemble_state("libero_eef8d", bindings, joints, buffer.at(1))
    wanted = simulated(robot, positions)["panda_hand"]
    angle = float(np.linalg.norm(values[3:6]))
    turn = np.empty(9)
    mujoco.mju_axisAngle2Quat(quat := np.empty(4), values[3:6] / angle, angle)
    mujoco.mju_quat2Mat(turn, quat)
    assert np.allclose(values[:3], wanted[:3, 3], atol=1e-6)
    assert np.allclose(turn.reshape(3, 3), wanted[:3, :3], atol=1e-6)
