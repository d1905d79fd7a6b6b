"""Our URDF against the simulator's own body and site poses."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import robosuite

from fairlead.robot.manifest import RobotManifest, load_robot

SAMPLES = 1000
POSITION_TOLERANCE_M = 1e-4
ROTATION_TOLERANCE_RAD = 1e-4


@pytest.fixture(scope="module")
def robot() -> RobotManifest:
    return load_robot("panda_mobile")


@pytest.fixture(scope="module")
def simulator_model() -> mujoco.MjModel:
    env = robosuite.make(
        "Lift",
        robots="PandaOmron",
        has_renderer=False,
        has_offscreen_renderer=False,
        use_camera_obs=False,
    )
    return env.sim.model._model


def _pose(model: mujoco.MjModel, data: mujoco.MjData, reference: str) -> pin.SE3:
    kind, name = reference.split(":")
    item = data.body(name) if kind == "body" else data.site(name)
    return pin.SE3(item.xmat.reshape(3, 3).copy(), item.xpos.copy())


@pytest.mark.simulator
def test_every_shared_frame_agrees_with_the_simulator_at_random_joint_positions(
    robot: RobotManifest, simulator_model: mujoco.MjModel
) -> None:
    assert robot.simulator is not None
    model = pin.buildModelFromUrdf(str(robot.description_path()))
    data, simulated = model.createData(), mujoco.MjData(simulator_model)
    rng = np.random.default_rng(20)
    worst: dict[str, tuple[float, float]] = dict.fromkeys(robot.simulator.frames, (0.0, 0.0))
    for _ in range(SAMPLES):
        q = np.zeros(model.nq)
        for joint in (*robot.joints, *robot.passive_joints):
            sources = robot.simulator.joints[joint.name]
            if len(sources) > 1:  # the opening: its two fingers are set on their own
                continue
            value = rng.uniform(joint.lower, joint.upper) if joint.has_bounds else rng.normal()
            address = simulator_model.jnt_qposadr[simulator_model.joint(sources[0]).id]
            simulated.qpos[address] = value
            if model.existJointName(joint.name):
                q[model.joints[model.getJointId(joint.name)].idx_q] = value
        mujoco.mj_kinematics(simulator_model, simulated)
        pin.framesForwardKinematics(model, data, q)
        world_base = _pose(simulator_model, simulated, f"body:{robot.simulator.base_body}")
        for frame, reference in robot.simulator.frames.items():
            truth = world_base.actInv(_pose(simulator_model, simulated, reference))
            ours = data.oMf[model.getFrameId(frame, pin.FrameType.BODY)]
            error = truth.actInv(ours)
            distance = float(np.linalg.norm(error.translation))
            angle = float(np.linalg.norm(pin.log3(error.rotation)))
            worst[frame] = (max(worst[frame][0], distance), max(worst[frame][1], angle))
    wrong = {
        frame: errors
        for frame, errors in worst.items()
        if errors[0] > POSITION_TOLERANCE_M or errors[1] > ROTATION_TOLERANCE_RAD
    }
    assert wrong == {}


def test_description_has_every_frame_the_manifest_shares_with_the_simulator(
    robot: RobotManifest,
) -> None:
    model = pin.buildModelFromUrdf(str(robot.description_path()))
    frames = {frame.name for frame in model.frames if frame.type == pin.FrameType.BODY}
    named = {f"panda_link{index}" for index in range(9)} | {
        "base_link",
        "base_site",
        "grip_site",
        "panda_hand",
        "panda_hand_tcp",
    }
    assert named <= frames
    assert robot.simulator is not None
    assert set(robot.simulator.frames) <= frames


def test_joints_of_the_description_are_those_of_the_manifest(robot: RobotManifest) -> None:
    model = pin.buildModelFromUrdf(str(robot.description_path()))
    not_in_tree = {*robot.base_joints, "panda_gripper"}
    assert set(model.names) - {"universe"} == set(robot.measured_joint_names) - not_in_tree


def test_position_limits_of_the_description_are_those_of_the_manifest(
    robot: RobotManifest,
) -> None:
    model = pin.buildModelFromUrdf(str(robot.description_path()))
    for name in list(model.names)[1:]:
        index = model.joints[model.getJointId(name)].idx_q
        joint = robot.joint(name)
        assert model.lowerPositionLimit[index] == joint.lower, name
        assert model.upperPositionLimit[index] == joint.upper, name
