"""End-effector commands: every axis in its direction and size, in the named frame, no drift."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest, load_robot
from tests.hal_mujoco.dual_panda import OTHER, TOOLS, DualPanda, tool_row

pytestmark = pytest.mark.simulator

DELTA = np.array([0.004, -0.007, 0.01, 0.01, -0.02, 0.03])
TICKS, SETTLE = 10, 30
DRIFT_M, MINUTE_TICKS = 0.005, 1200
ARMS = sorted(TOOLS)
LEFT_JOINTS = tuple(f"left_joint{number}" for number in range(1, 8))


@pytest.fixture(scope="module")
def robot() -> RobotManifest:
    return load_robot("dual_panda")


@pytest.fixture
def world(robot: RobotManifest) -> DualPanda:
    return DualPanda(robot)


def pose_row(position: FloatArray, rotation: FloatArray) -> PartCommand:
    xyzw = pin.Quaternion(rotation).coeffs()
    return tool_row(ControlMode.CARTESIAN_POSE, [*position, *xyzw])


@pytest.mark.parametrize("part", ARMS)
@pytest.mark.parametrize("per_second", [False, True], ids=["delta", "twist"])
def test_deltas_and_twists_move_the_tool_along_the_frames_axes_and_nothing_else(
    world: DualPanda, part: str, per_second: bool
) -> None:
    mode = ControlMode.CARTESIAN_TWIST if per_second else ControlMode.CARTESIAN_DELTA
    row = tool_row(mode, DELTA / 0.05 if per_second else DELTA)
    (position, rotation), other = world.tool(part), world.tool(OTHER[part])
    world.run({part: row}, TICKS, hold=SETTLE)
    moved, turned = world.tool(part)
    np.testing.assert_allclose(moved - position, TICKS * DELTA[:3], rtol=0, atol=1e-5)
    # R' = exp(r) R ten times over: the rotations share an axis, so their vectors add up.
    np.testing.assert_allclose(pin.log3(turned @ rotation.T), TICKS * DELTA[3:], rtol=0, atol=1e-5)
    np.testing.assert_array_equal(world.tool(OTHER[part])[0], other[0])


@pytest.mark.parametrize("part", ARMS)
def test_a_pose_is_where_the_tool_comes_to_rest(world: DualPanda, part: str) -> None:
    position, rotation = world.tool(part)
    for share in np.linspace(0.0, 1.0, 11)[1:]:
        goal = position + share * np.array([0.03, -0.02, 0.05])
        turn = pin.exp3(share * np.array([0.1, 0.2, -0.3])) @ rotation
        world.run({part: pose_row(goal, turn)}, 1)
    world.run({}, 0, hold=SETTLE)
    at, turned = world.tool(part)
    np.testing.assert_allclose(at, goal, rtol=0, atol=1e-5)
    np.testing.assert_allclose(turned, turn, rtol=0, atol=1e-5)


def test_a_far_pose_is_approached_no_faster_than_the_joints_may_turn(world: DualPanda) -> None:
    position, rotation = world.tool("left_arm")
    speed = np.array([world.robot.joint(n).velocity_limit for n in LEFT_JOINTS])
    row = pose_row(position + np.array([0.2, 0.0, 0.0]), rotation)
    before = world.backend._setpoints.positions.copy()
    for _ in range(30):
        world.run({"left_arm": row}, 1)
        after = world.backend._setpoints.positions
        assert np.all(np.abs(after - before)[:7] <= speed * 0.05 + 1e-12)
        before = after.copy()
    np.testing.assert_allclose(world.tool("left_arm")[0] - position, [0.2, 0, 0], atol=1e-3)


@pytest.mark.parametrize(
    "hold",
    [
        pytest.param(True, id="held", marks=pytest.mark.thorough),
        pytest.param(False, id="zero deltas"),
    ],
)
def test_a_still_tool_does_not_drift_in_a_minute(world: DualPanda, hold: bool) -> None:
    mode = ControlMode.CARTESIAN_DELTA
    world.run({"right_arm": tool_row(mode, DELTA)}, TICKS, hold=SETTLE)
    start, _ = world.tool("right_arm")
    world.run({} if hold else {"right_arm": tool_row(mode, np.zeros(6))}, MINUTE_TICKS)
    assert np.linalg.norm(world.tool("right_arm")[0] - start) < DRIFT_M


def test_at_a_joints_limit_the_tool_stops_on_its_way(world: DualPanda) -> None:
    start, _ = world.tool("left_arm")
    down = tool_row(ControlMode.CARTESIAN_TWIST, [0.0, 0.0, -0.4, 0.0, 0.0, 0.0])
    world.backend._model.geom_conaffinity[:] = 0
    world.run({"left_arm": down}, 80, hold=SETTLE)
    end, _ = world.tool("left_arm")
    at = dict(zip(world.robot.joint_names, world.backend._setpoints.positions, strict=True))
    limits = [(at[n], world.robot.joint(n)) for n in LEFT_JOINTS]
    assert any(value in (joint.lower, joint.upper) for value, joint in limits), at
    assert end[2] < start[2] - 0.2 and np.all(np.abs(end - start)[:2] < 0.005), end - start


def test_tools_driven_at_full_scale_break_no_measured_limit(world: DualPanda) -> None:
    world.backend._model.geom_conaffinity[:] = 0  # nothing to hit
    robot, rng = world.robot, np.random.default_rng(1)
    names = robot.measured_joint_names
    limits = [robot.profile("sim").measured[name] for name in names]
    joints = [robot.joint(name) for name in names]
    twists: dict[str, PartCommand] = {}
    before, fastest = world.backend.read().positions, 0.0
    for tick in range(300):
        if tick % 15 == 0:
            for part in ARMS:
                way, turn = rng.normal(size=(2, 3))
                halves = [way / np.linalg.norm(way), 2.5 * turn / np.linalg.norm(turn)]
                twists[part] = tool_row(ControlMode.CARTESIAN_TWIST, np.concatenate(halves))
        world.backend.apply(twists)
        now = world.backend.read().positions
        for joint, limit, old, new in zip(joints, limits, before, now, strict=True):
            assert limit.tolerance is not None
            assert abs(new - old) < limit.jump_per_tick, joint.name
            assert joint.lower - limit.tolerance < new < joint.upper + limit.tolerance
        fastest, before = max(fastest, float(np.abs(now - before).max())), now
    assert fastest > 0.08, "the drive was too gentle to prove anything"
