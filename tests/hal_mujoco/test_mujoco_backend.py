"""The plain MuJoCo backend with the shipped robot, and models that do not fit it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from fairlead.errors import ConfigError, HardwareError
from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead.paths import gate_config, repo_root, robot_dir
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_mujoco.options import MujocoOptions

pytestmark = pytest.mark.simulator

ARM = tuple(range(7))
GOAL = np.array([0.6, 0.2, -0.4, -1.7, 0.3, 2.3, 0.3, 0.02])


@pytest.fixture(scope="module")
def robot() -> RobotManifest:
    return load_robot("panda")


@pytest.fixture
def backend(robot: RobotManifest) -> MujocoBackend:
    return MujocoBackend(robot)


def arm(mode: ControlMode, values: np.ndarray) -> PartCommand:
    return PartCommand(mode, "", np.append(values, 0.0), ARM)


def gripper(value: float) -> PartCommand:
    return PartCommand(ControlMode.GRIPPER_POSITION, "", np.array([value]), ())


def test_committed_gate_file_is_what_the_manifest_compiles_to(robot: RobotManifest) -> None:
    committed = gate_config("panda", "sim").read_text(encoding="utf-8")
    assert committed == compile_gate_config(robot, "sim")


def test_every_shared_frame_of_the_description_agrees_with_the_model(robot: RobotManifest) -> None:
    assert robot.simulator is not None
    ours = pin.buildModelFromUrdf(str(robot.description_path()))
    found = ours.createData()
    model = mujoco.MjModel.from_xml_path(str(robot_dir("panda") / "panda.xml"))
    data = mujoco.MjData(model)
    rng = np.random.default_rng(4)
    for _ in range(200):
        q = np.zeros(ours.nq)
        for joint in (*robot.joints[:7], *robot.passive_joints):
            value = rng.uniform(joint.lower, joint.upper)
            data.joint(joint.name).qpos[0] = value
            q[ours.joints[ours.getJointId(joint.name)].idx_q] = value
        mujoco.mj_kinematics(model, data)
        pin.framesForwardKinematics(ours, found, q)
        for frame, reference in robot.simulator.frames.items():
            kind, name = reference.split(":")
            item = data.body(name) if kind == "body" else data.site(name)
            truth = pin.SE3(item.xmat.reshape(3, 3).copy(), item.xpos.copy())
            error = truth.actInv(found.oMf[ours.getFrameId(frame, pin.FrameType.BODY)])
            assert np.linalg.norm(error.translation) < 1e-6, frame
            assert np.linalg.norm(pin.log3(error.rotation)) < 1e-6, frame


def test_describes_the_joints_parts_and_ranges_of_the_manifest(
    backend: MujocoBackend, robot: RobotManifest
) -> None:
    found = backend.describe()
    assert found.joints == robot.joint_names
    assert found.passive_joints == robot.passive_joint_names
    assert [part.name for part in found.parts] == ["arm", "gripper"]
    assert found.has_task


def test_holding_from_the_start_does_not_drift(backend: MujocoBackend) -> None:
    start = backend.read().positions
    for _ in range(200):
        backend.apply({})
    np.testing.assert_allclose(backend.read().positions, start, rtol=0, atol=1e-5)


def test_holding_after_motion_comes_to_rest_and_stays(
    backend: MujocoBackend, robot: RobotManifest
) -> None:
    for _ in range(10):
        backend.apply({"arm": arm(ControlMode.JOINT_VELOCITY, np.full(7, 0.4)),
                       "gripper": gripper(0.03)})  # fmt: skip
    for _ in range(40):
        backend.apply({})
    rest = backend.read()
    measured = robot.profile("sim").measured
    still = [measured[name].standstill_per_s for name in robot.measured_joint_names]
    assert np.all(np.abs(rest.velocities) < still)
    for _ in range(200):
        backend.apply({})
    np.testing.assert_allclose(backend.read().positions, rest.positions, rtol=0, atol=1e-4)


def test_position_commands_are_reached(backend: MujocoBackend) -> None:
    target = backend.read().positions[:7] + np.array([0.1, -0.08, 0.06, 0.09, -0.1, 0.05, 0.1])
    for _ in range(20):
        backend.apply({"arm": arm(ControlMode.JOINT_POSITION, target)})
    np.testing.assert_allclose(backend.read().positions[:7], target, rtol=0, atol=2e-3)


def test_velocity_commands_are_measured_velocities(backend: MujocoBackend) -> None:
    rates = np.array([0.3, -0.2, 0.25, 0.1, -0.3, 0.2, 0.4])
    for _ in range(20):
        backend.apply({"arm": arm(ControlMode.JOINT_VELOCITY, rates)})
    np.testing.assert_allclose(backend.read().velocities[:7], rates, rtol=0, atol=0.01)


def test_the_opening_is_the_difference_of_two_fingers_that_share_it(backend: MujocoBackend) -> None:
    for _ in range(40):
        backend.apply({"gripper": gripper(0.03)})
    opening, left, right = backend.read().positions[7:]
    assert opening == left - right
    np.testing.assert_allclose([opening, left, right], [0.03, 0.015, -0.015], atol=1e-4)


def test_full_scale_driving_stays_within_tolerance_and_jump_limits(robot: RobotManifest) -> None:
    backend, rng = MujocoBackend(robot), np.random.default_rng(0)
    backend._model.geom_conaffinity[:] = 0  # nothing to hit: a blow is what the gate stops for
    limits = robot.profile("sim").measured
    jump = np.array([limits[name].jump_per_tick for name in robot.measured_joint_names])
    arms = robot.joints[:7]
    full = np.array([joint.velocity_limit for joint in arms])
    rates, before = np.zeros(7), backend.read().positions
    for tick in range(600):
        if tick % 17 == 0:
            wanted, opening = rng.choice([-1.0, 0.0, 1.0], 7) * full, rng.choice([0.0, 0.08])
        reach = np.array([joint.acceleration_limit for joint in arms]) * 0.05
        rates = np.clip(wanted, rates - reach, rates + reach)
        backend.apply({"arm": arm(ControlMode.JOINT_VELOCITY, rates), "gripper": gripper(opening)})
        now = backend.read().positions
        assert np.all(np.abs(now - before) < jump)
        for name, position in zip(robot.measured_joint_names, now, strict=True):
            joint, tolerance = robot.joint(name), limits[name].tolerance
            assert tolerance is not None
            assert joint.lower - tolerance < position < joint.upper + tolerance, name
        before = now


def test_same_seed_same_bits_other_seed_other_start(backend: MujocoBackend) -> None:
    def run(seed: int) -> np.ndarray:
        backend.reset(seed)
        for _ in range(5):
            backend.apply({"arm": arm(ControlMode.JOINT_VELOCITY, np.full(7, 0.3))})
        return np.concatenate(backend.generalized_state())

    first = run(1)
    assert not np.array_equal(run(2), first)
    np.testing.assert_array_equal(run(1), first)


def test_task_succeeds_at_the_goal_key_only_and_only_at_rest(backend: MujocoBackend) -> None:
    reading = backend.task()
    assert reading is not None and not reading.success
    way = GOAL[:7] - backend.read().positions[:7]
    start = backend.read().positions[:7]
    for step in np.linspace(0, 1, 21):
        backend.apply({"arm": arm(ControlMode.JOINT_POSITION, start + step * way),
                       "gripper": gripper(GOAL[7])})  # fmt: skip
    moving = backend.task()
    assert moving is not None and not moving.success
    for _ in range(20):
        backend.apply({})
    resting = backend.task()
    assert resting is not None and resting.success, resting


@pytest.fixture
def mujoco_warnings() -> Iterator[list[str]]:
    """What MuJoCo warns of, kept from the terminal and from MUJOCO_LOG.TXT."""
    texts: list[str] = []
    mujoco.set_mju_user_warning(texts.append)
    yield texts
    mujoco.set_mju_user_warning(None)


def test_a_diverged_simulation_is_an_error_and_not_a_new_start(
    backend: MujocoBackend, mujoco_warnings: list[str]
) -> None:
    backend._data.qvel[0] = np.nan
    with pytest.raises(HardwareError, match="the simulation diverged at"):
        backend.apply({})
    assert any("QVEL" in text for text in mujoco_warnings)


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with the robot alone, so that its model can be changed."""
    (tmp_path / "rskills").mkdir()
    shutil.copytree(repo_root() / "robots" / "panda", tmp_path / "robots" / "panda")
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    return tmp_path / "robots" / "panda"


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("panda_joint3", "elbow",
         "hal_mujoco: expected a hinge or slide of the model for joint panda_joint3, got "
         "'panda_joint3' (valid: panda_joint1, panda_joint2, elbow, "),
        ('<position name="panda_joint2" class="proximal"', '<motor name="panda_joint2"',
         "hal_mujoco: joint panda_joint2: expected one <position> actuator on 'panda_joint2', "
         "got panda_joint2"),
        ('range="-1.7628 1.7628"/>\n', 'range="-1.5 1.7628"/>\n',
         "hal_mujoco: joint panda_joint2: range: expected at least [-1.7628, 1.7628] rad "
         "(robot.yaml), got [-1.5, 1.7628] in the model"),
        ('timestep="0.002"', 'timestep="0.003"',
         "timestep: expected a whole part of the control period of 0.05 s, got 0.003 s"),
        ('body name="base_link"', 'body name="foot"',
         "hal_mujoco: expected a body of the model, got 'base_link' (valid: world, foot, "),
        ("<mujoco", "<mujoc", "panda.xml: XML parse error 14: Error="),
    ],
)  # fmt: skip
def test_a_model_that_does_not_fit_the_manifest_is_refused(
    checkout: Path, old: str, new: str, text: str
) -> None:
    path = checkout / "panda.xml"
    before = path.read_text(encoding="utf-8")
    assert old in before
    path.write_text(before.replace(old, new), encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        MujocoBackend(load_robot("panda"))
    assert text in str(caught.value)


def test_a_missing_model_is_named(robot: RobotManifest) -> None:
    path = robot_dir("panda") / "other.xml"
    with pytest.raises(ConfigError) as caught:
        MujocoBackend(robot, options=MujocoOptions(model="other.xml"))
    assert str(caught.value) == f"hal_mujoco: expected an MJCF file, got none at {path}"
