"""The backend without physics does what a manifest says, and stands still without commands."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.hal.backend import PartCommand
from fairlead.messages import floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.robot.safety_profile import profile_limits
from fairlead_hal_kinematic.kinematic_backend import KinematicBackend

ROBOT = load_robot("panda_mobile")
N = ROBOT.n_dof


@pytest.fixture
def backend() -> KinematicBackend:
    return KinematicBackend(ROBOT, frames={"object": (0.5, 0.0, 0.9)})


def command(mode: ControlMode, values: list[float], active: tuple[int, ...] = ()) -> PartCommand:
    return PartCommand(mode=mode, frame_id="base_link", values=np.array(values), active=active)


def base_velocity(x: float, yaw: float, active: tuple[int, ...] = (0, 2)) -> PartCommand:
    return command(ControlMode.JOINT_VELOCITY, [x, 0.0, yaw] + [0.0] * (N - 3), active)


def test_a_velocity_is_integrated_over_one_period(backend: KinematicBackend) -> None:
    backend.apply({"base": base_velocity(0.4, 0.0)})
    measured = backend.read()
    assert measured.positions[0] == pytest.approx(0.02)
    assert measured.velocities[0] == pytest.approx(0.4)


def test_without_commands_everything_stands_still_at_once(backend: KinematicBackend) -> None:
    backend.apply({"base": base_velocity(0.4, 0.1)})
    before = backend.read().positions
    backend.apply({})
    assert np.array_equal(backend.read().positions, before)
    assert not backend.read().velocities.any()


def test_a_body_twist_drives_along_the_turned_base(backend: KinematicBackend) -> None:
    for _ in range(20):
        backend.apply({"base": base_velocity(0.0, np.pi / 2)})
    backend.apply({"base": command(ControlMode.BODY_TWIST, [0.2, 0.0, 0.0, 0.0, 0.0, 0.0])})
    assert backend.read().velocities[:2] == pytest.approx([0.0, 0.2], abs=1e-12)
    pose = backend.transforms()[0]
    assert (pose.parent, pose.child) == ("odom", "base_link")
    assert pose.rotation_xyzw[2:] == pytest.approx([np.sin(np.pi / 4), np.cos(np.pi / 4)])


def test_base_velocities_are_turned_against_the_yaw_where_the_profile_says_so(
    backend: KinematicBackend,
) -> None:
    assert ROBOT.profile("sim").base.command_frame == "against_yaw"  # type: ignore[union-attr]
    for _ in range(20):
        backend.apply({"base": base_velocity(0.0, np.pi / 2)})
    backend.apply({"base": base_velocity(0.2, 0.0, active=(0, 1, 2))})
    assert backend.read().velocities[:2] == pytest.approx([0.0, -0.2], abs=1e-12)


def test_the_fingers_share_the_total_opening(backend: KinematicBackend) -> None:
    for _ in range(40):
        backend.apply({"gripper": command(ControlMode.GRIPPER_POSITION, [0.06])})
    positions = backend.read().positions
    assert positions[N - 1] == pytest.approx(0.06)
    assert positions[N : N + 2] == pytest.approx([0.03, -0.03])


def test_bounded_joints_stay_in_their_range(backend: KinematicBackend) -> None:
    for _ in range(2000):
        backend.apply({"arm": command(ControlMode.CARTESIAN_DELTA, [0.05] * 3 + [0.5] * 3)})
    for index, joint in enumerate(ROBOT.joints):
        if joint.has_bounds:
            assert joint.lower <= backend.read().positions[index] <= joint.upper


def test_a_tool_command_moves_no_joint_faster_than_it_may(backend: KinematicBackend) -> None:
    backend.apply({"arm": command(ControlMode.CARTESIAN_DELTA, [5.0, -5.0] * 3)})
    arm = [ROBOT.joint_names.index(name) for name in ROBOT.part("arm").joints]
    safety = ROBOT.profile("sim")
    fastest = np.array([profile_limits(ROBOT.joints[joint], safety)[0] for joint in arm])
    assert np.abs(backend.read().velocities[arm]) == pytest.approx(fastest)


def test_a_seed_decides_the_start(backend: KinematicBackend) -> None:
    backend.reset(3)
    first = backend.read().positions
    backend.reset(4)
    assert not np.array_equal(backend.read().positions, first)
    backend.reset(3)
    assert np.array_equal(backend.read().positions, first)


def test_it_starts_at_home_and_no_seed_moves_a_joint_by_more_than_a_hundredth_of_its_range(
    backend: KinematicBackend,
) -> None:
    assert ROBOT.home is not None
    for seed in range(20):
        backend.reset(seed)
        measured = dict(zip(ROBOT.measured_joint_names, backend.read().positions, strict=True))
        for name, home in ROBOT.home.positions.items():
            span = ROBOT.joint(name).upper - ROBOT.joint(name).lower
            assert abs(measured[name] - home) <= 0.01 * span + 1e-6, name
        assert measured["torso_height"] == ROBOT.home.positions["torso_height"]


def test_a_robot_that_declares_no_home_starts_in_the_middle_of_its_ranges() -> None:
    robot = ROBOT.model_copy(update={"home": None})
    backend = KinematicBackend(robot)
    measured = dict(zip(robot.measured_joint_names, backend.read().positions, strict=True))
    for joint in (*robot.joints, *robot.passive_joints):
        if joint.has_bounds:
            middle, span = 0.5 * (joint.lower + joint.upper), joint.upper - joint.lower
            assert abs(measured[joint.name] - middle) <= 0.01 * span + 1e-9, joint.name
        else:
            assert measured[joint.name] == 0.0


def test_ranges_are_the_limits_of_the_profile(backend: KinematicBackend) -> None:
    ranges = {
        (part.name, item.mode): floats(item.upper)
        for part in backend.describe().parts
        for item in part.ranges
    }
    assert ranges["base", ControlMode.JOINT_VELOCITY].tolist() == [1.0, 1.0, 1.5]
    assert ranges["gripper", ControlMode.GRIPPER_POSITION].tolist() == [0.08]
    assert ranges["arm", ControlMode.CARTESIAN_DELTA][0] >= 0.05


def dual_panda_without(*modes: str) -> RobotManifest:
    """The robot of two arms, less what a robot without physics cannot do."""
    robot = load_robot("dual_panda")
    parts = [
        part.model_copy(update={"modes": tuple(mode for mode in part.modes if mode not in modes)})
        for part in robot.parts
    ]
    return robot.model_copy(update={"parts": tuple(parts)})


def test_a_hand_a_binary_gripper_and_a_twist_of_a_tool_move_their_own_joints() -> None:
    robot = dual_panda_without("cartesian_pose")
    backend, hand = KinematicBackend(robot), list(range(15, 21))
    start, row = backend.read().positions, np.zeros(robot.n_dof)
    row[hand] = start[hand] + [0.05, -0.06, 0.07, -0.08, 0.09, -0.1]
    bend = PartCommand(ControlMode.DEX_HAND_JOINT, "", row, tuple(hand))
    twist = command(ControlMode.CARTESIAN_TWIST, [0.1, -0.2, 0.3, -0.4, 0.5, -0.6])
    backend.apply({"right_hand": bend, "left_arm": twist})
    now = backend.read().positions
    assert now[hand] == pytest.approx(row[hand])
    assert np.array_equal(np.sign(now - start)[:6], np.sign(twist.values))
    assert np.array_equal(now[7:15], start[7:15]), "the right arm and the left gripper stand"
    for value, opening in ((1.0, 0.0), (0.0, 0.08)):
        for _ in range(40):
            backend.apply({"left_gripper": command(ControlMode.GRIPPER_BINARY, [value])})
        assert backend.read().positions[7] == pytest.approx(opening)


def test_a_robot_with_poses_is_refused_at_start() -> None:
    with pytest.raises(ConfigError) as caught:
        KinematicBackend(load_robot("dual_panda"))
    assert str(caught.value) == (
        "hal_kinematic: part left_arm: expected a mode it can do, got cartesian_pose (valid: "
        "joint_position, joint_velocity, cartesian_delta, cartesian_twist, gripper_binary, "
        "gripper_position, dex_hand_joint, body_twist, composite_mode)"
    )
