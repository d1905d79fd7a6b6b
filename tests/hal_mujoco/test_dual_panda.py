"""Robot dual_panda: its files agree with each other, and its home is a place to start from."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest, load_robot
from tests.hal_mujoco.dual_panda import DualPanda

pytestmark = pytest.mark.simulator

AWAY_FROM_LIMITS = 0.1
"""Of a joint's range, at key home."""


@pytest.fixture(scope="module")
def robot() -> RobotManifest:
    return load_robot("dual_panda")


def test_every_frame_of_the_description_agrees_with_the_model(robot: RobotManifest) -> None:
    assert robot.simulator is not None
    ours = pin.buildModelFromUrdf(str(robot.description_path()))
    found = ours.createData()
    model = mujoco.MjModel.from_xml_path(str(robot_dir(robot.id) / "dual_panda.xml"))
    data, rng = mujoco.MjData(model), np.random.default_rng(4)
    for _ in range(200):
        q = np.zeros(ours.nq)
        for name in list(ours.names)[1:]:
            joint = robot.joint(name)
            value = rng.uniform(joint.lower, joint.upper)
            data.joint(name).qpos[0] = value
            q[ours.joints[ours.getJointId(name)].idx_q] = value
        mujoco.mj_kinematics(model, data)
        pin.framesForwardKinematics(ours, found, q)
        base = data.body("base_link")
        world_base = pin.SE3(base.xmat.reshape(3, 3).copy(), base.xpos.copy())
        for frame, reference in robot.simulator.frames.items():
            kind, name = reference.split(":")
            item = data.body(name) if kind == "body" else data.site(name)
            truth = pin.SE3(item.xmat.reshape(3, 3).copy(), item.xpos.copy())
            here = found.oMf[ours.getFrameId(frame, pin.FrameType.BODY)]
            error = world_base.actInv(truth).actInv(here)
            assert np.linalg.norm(error.translation) < 1e-6, frame
            assert np.linalg.norm(pin.log3(error.rotation)) < 1e-6, frame


def test_the_manifest_shares_every_link_but_the_flanges_with_the_model(
    robot: RobotManifest,
) -> None:
    ours = pin.buildModelFromUrdf(str(robot.description_path()))
    links = {frame.name for frame in ours.frames if frame.type == pin.FrameType.BODY}
    assert robot.simulator is not None
    assert links - set(robot.simulator.frames) == {"left_link8", "right_link8"}


def test_joints_and_limits_of_the_description_are_those_of_the_manifest(
    robot: RobotManifest,
) -> None:
    model = pin.buildModelFromUrdf(str(robot.description_path()))
    assert set(model.names) - {"universe"} == set(robot.measured_joint_names) - {"left_gripper"}
    for name in list(model.names)[1:]:
        index, joint = model.joints[model.getJointId(name)].idx_q, robot.joint(name)
        assert model.lowerPositionLimit[index] == joint.lower, name
        assert model.upperPositionLimit[index] == joint.upper, name
        assert model.velocityLimit[index] == joint.velocity_limit, name
        assert model.effortLimit[index] == joint.effort_limit, name


def test_home_is_well_away_from_every_limit(robot: RobotManifest) -> None:
    measured = DualPanda(robot).backend.read().positions
    for name, position in zip(robot.measured_joint_names, measured, strict=True):
        joint = robot.joint(name)
        room = AWAY_FROM_LIMITS * (joint.upper - joint.lower)
        assert joint.lower + room < position < joint.upper - room, name


def test_full_scale_driving_stays_within_tolerance_and_jump_limits(robot: RobotManifest) -> None:
    world, rng = DualPanda(robot), np.random.default_rng(0)
    world.backend._model.geom_conaffinity[:] = 0  # nothing to hit: a blow is what the gate stops
    limits, before = robot.profile("sim").measured, world.backend.read().positions
    rates = {part: np.zeros(7) for part in ("left_arm", "right_arm")}
    hand = world.positions("right_hand")
    for tick in range(300):
        if tick % 17 == 0:
            wanted = {part: rng.choice([-1.0, 0.0, 1.0], 7) for part in rates}
            fist, closed = rng.choice([-1.0, 1.0], 6), float(rng.choice([0.0, 1.0]))
        commands = {"left_gripper": PartCommand(ControlMode.GRIPPER_BINARY, "",
                                                np.array([closed]), ())}  # fmt: skip
        for part, rate in rates.items():
            joints = [robot.joint(name) for name in robot.part(part).joints]
            reach = np.array([joint.acceleration_limit for joint in joints]) * 0.05
            goal = wanted[part] * np.array([joint.velocity_limit for joint in joints])
            rates[part] = np.clip(goal, rate - reach, rate + reach)
            commands[part] = world.joint_row(ControlMode.JOINT_VELOCITY, part, rates[part])
        joints = [robot.joint(name) for name in robot.part("right_hand").joints]
        lower, upper = ([getattr(j, end) for j in joints] for end in ("lower", "upper"))
        hand = np.clip(hand + 0.15 * fist, lower, upper)
        commands["right_hand"] = world.joint_row(ControlMode.DEX_HAND_JOINT, "right_hand", hand)
        world.backend.apply(commands)
        now = world.backend.read().positions
        for name, old, new in zip(robot.measured_joint_names, before, now, strict=True):
            joint, tolerance = robot.joint(name), limits[name].tolerance
            assert tolerance is not None
            assert abs(new - old) < limits[name].jump_per_tick, name
            assert joint.lower - tolerance < new < joint.upper + tolerance, name
        before = now


def test_the_arms_collide_with_each_other_and_not_with_themselves(robot: RobotManifest) -> None:
    backend = DualPanda(robot).backend
    model, data = backend._model, backend._data
    data.joint("left_joint1").qpos[0], data.joint("right_joint1").qpos[0] = -1.6, 1.6
    mujoco.mj_forward(model, data)
    sides = [
        {model.body(int(model.geom_bodyid[geom])).name.split("_")[0] for geom in contact.geom}
        for contact in data.contact
    ]
    assert sides and all(side == {"left", "right"} for side in sides), sides
