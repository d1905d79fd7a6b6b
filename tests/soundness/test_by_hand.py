"""What the campaigns measure with, against numbers worked out by hand."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from bench.equipment.kinematics import Kinematics
from bench.soundness.arena import Arena
from bench.soundness.distances import between_polygons, between_segments, inside_polygon
from bench.soundness.link_frames import LinkFrames
from bench.soundness.prediction import Prediction
from bench.soundness.share_robot import ShareRobot
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def points(*rows: list[float]) -> FloatArray:
    return np.array(rows, dtype=np.float64)


def file_of(robot: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(gate_config(robot, "sim").read_text())
    return found


def test_distances_of_segments_that_cross_above_pass_by_and_end_short_of_each_other() -> None:
    start, end = points([0, 0, 0], [0, 0, 0], [0, 0, 0]), points([1, 0, 0], [1, 0, 0], [0, 0, 0])
    other = points([0.5, -1, 0.3], [2, 0, 0], [0, 3, 4])
    other_end = points([0.5, 1, 0.3], [3, 0, 0], [0, 3, 4])
    found = between_segments(start, end, other, other_end)
    np.testing.assert_allclose(found, [0.3, 1.0, 5.0], rtol=0, atol=1e-12)


def test_distances_of_segments_agree_with_the_nearest_of_many_points() -> None:
    rng = np.random.default_rng(3)
    ends = rng.normal(size=(4, 200, 3))
    shares = np.linspace(0.0, 1.0, 200)[:, None, None]
    one = ends[0] + (ends[1] - ends[0]) * shares
    other = ends[2] + (ends[3] - ends[2]) * shares
    nearest = [
        np.linalg.norm(one[:, None, k] - other[None, :, k], axis=-1).min() for k in range(200)
    ]
    found = between_segments(*ends)
    assert np.all(found <= np.array(nearest) + 1e-9)
    np.testing.assert_allclose(found, nearest, rtol=0, atol=0.02)


def test_a_point_in_a_square_and_one_beyond_its_edge() -> None:
    found = inside_polygon(points([0.3, 0.5], [1.25, 0.5]), SQUARE)
    np.testing.assert_allclose(found, [0.3, -0.25], rtol=0, atol=1e-12)


def test_the_gap_between_two_squares_and_their_overlap() -> None:
    shapes = np.stack([SQUARE + np.array([1.5, 0.0]), SQUARE + np.array([0.75, 0.0])])
    np.testing.assert_allclose(between_polygons(shapes, SQUARE), [0.5, -0.25], rtol=0, atol=1e-12)


@pytest.mark.parametrize("robot", ["panda_mobile", "dual_panda"])
def test_link_frames_are_where_pinocchio_has_them(robot: str) -> None:
    manifest = load_robot(robot)
    links = LinkFrames(file_of(robot))
    kinematics = Kinematics(manifest.description_path(), manifest.measured_joint_names)
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (5, len(manifest.measured_joint_names)))
    places, turns = links.at(q)
    for tool in manifest.end_effectors:
        at = links.names.index(tool.tool_frame)
        for index in range(len(q)):
            place, turn = kinematics.pose(q[index], tool.tool_frame, manifest.base_frame)
            np.testing.assert_allclose(places[at, index], place, rtol=0, atol=1e-9)
            np.testing.assert_allclose(turns[at, index], turn, rtol=0, atol=1e-9)


def test_the_footprint_of_a_turned_base_turns_about_its_yaw_axis() -> None:
    file = file_of("panda_mobile")
    file["base"]["yaw_axis"] = [-0.25, 0.0]
    file["base"]["footprint"] = [[-0.5, -0.25], [0.25, -0.25], [0.25, 0.25], [-0.5, 0.25]]
    q = np.zeros((1, 14))
    q[0, :3] = 1.0, 2.0, np.pi / 2
    # From the axis at (0.75, 2): what was 0.5 ahead of it is now 0.5 to its left.
    wanted = [[1.0, 1.75], [1.0, 2.5], [0.5, 2.5], [0.5, 1.75]]
    np.testing.assert_allclose(Arena(file).footprint(q)[0], wanted, rtol=0, atol=1e-12)


def still_arm() -> tuple[Arena, FloatArray]:
    """The fixed arm at its home pose."""
    q = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.785, 0.04, 0.02, -0.02])
    return Arena(file_of("panda")), q[None, :]


def test_a_configuration_that_is_allowed_has_room_in_every_rule() -> None:
    arena, q = still_arm()
    assert {rule: bool(room[0] > 0.0) for rule, room in arena.room(q).items()} == {
        "bounds": True,
        "workspace": True,
        "self-collision": True,
        "zones": True,
    }


def test_a_joint_beyond_its_bound_is_a_breach_by_so_much() -> None:
    arena, q = still_arm()
    q[0, 0] = 2.9
    np.testing.assert_allclose(arena.room(q)["bounds"], [2.8973 - 2.9], rtol=0, atol=1e-12)


def test_a_tool_below_its_box_is_a_breach() -> None:
    arena, q = still_arm()
    q[0, [1, 3]] = 1.7, -0.3
    assert arena.room(q)["workspace"][0] < -0.05


def rows_of(*values: list[float]) -> list[dict[str, PartCommand]]:
    own = tuple(range(7))
    mode = ControlMode.JOINT_VELOCITY
    return [{"arm": PartCommand(mode, "", np.array([*row, 0.0]), own)} for row in values]


def test_velocities_are_followed_by_their_gain_between_its_ends() -> None:
    robot, file = load_robot("panda"), file_of("panda")
    arm = next(part for part in file["parts"] if part["name"] == "arm")
    arm["modes"]["joint_velocity"]["gain"] = [0.5, 1.0]
    start = still_arm()[1][0]
    rows = rows_of([1.0] + [0.0] * 6, [-2.0] + [0.0] * 6)
    path = Prediction(robot, file).follow(start, rows, np.array([0.0, 0.5]))
    # 50 ms at half of 1 rad/s, then at three quarters of -2 rad/s.
    np.testing.assert_allclose([q[0] - start[0] for q in path], [0.025, -0.05], atol=1e-12)
    np.testing.assert_allclose(path[1][1:], start[1:], atol=1e-12)


def test_each_part_has_a_share_of_its_own() -> None:
    robot, file = load_robot("dual_panda"), file_of("dual_panda")
    for part in file["parts"]:
        if part["name"].endswith("_arm"):
            part["modes"]["joint_velocity"]["gain"] = [0.5, 1.0]
    start, row = np.zeros(len(robot.measured_joint_names)), {}
    names = [part.name for part in robot.parts]
    for arm in ("left_arm", "right_arm"):
        joint = robot.joint_names.index(robot.part(arm).joints[0])
        values = np.zeros(len(robot.joint_names))
        values[joint] = 1.0
        row[arm] = PartCommand(ControlMode.JOINT_VELOCITY, "", values, (joint,))
    shares = np.zeros((1, len(names)))
    shares[0, names.index("right_arm")] = 1.0
    (end,) = Prediction(robot, file).follow(start, [row], shares)
    moved = {arm: end[row[arm].active[0]] for arm in row}
    assert moved == {"left_arm": pytest.approx(0.025), "right_arm": pytest.approx(0.05)}


def test_a_base_told_against_its_yaw_drives_to_its_right_after_a_quarter_turn() -> None:
    robot, file = load_robot("panda_mobile"), file_of("panda_mobile")
    part = next(part for part in file["parts"] if part["name"] == "base")
    part["modes"]["joint_velocity"]["gain"] = [1.0, 1.0]
    start, values = np.zeros(14), np.zeros(len(robot.joint_names))
    slide_x, slide_y, yaw = (robot.joint_names.index(n) for n in robot.part("base").joints)
    start[yaw], values[slide_x] = np.pi / 2, 1.0
    row = {"base": PartCommand(ControlMode.JOINT_VELOCITY, "", values, (slide_x, slide_y, yaw))}
    (end,) = Prediction(robot, file).follow(start, [row], np.array([0.0]))
    np.testing.assert_allclose(end[[slide_x, slide_y]], [0.0, -0.05], rtol=0, atol=1e-12)


def test_a_delta_moves_the_tool_by_its_share_along_base_links_axes() -> None:
    robot, file = load_robot("dual_panda"), file_of("dual_panda")
    part = next(part for part in file["parts"] if part["name"] == "left_arm")
    part["modes"]["cartesian_delta"]["gain"] = [0.0, 1.0]
    arms = [0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.785]
    start = np.array([*arms, 0.04, *arms, *[0.1] * 6, 0.02, -0.02])
    delta = np.array([0.02, -0.01, 0.03, 0.0, 0.0, 0.1])
    row = {"left_arm": PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", delta, ())}
    (end,) = Prediction(robot, file).follow(start, [row], np.array([0.5]))
    kinematics = Kinematics(robot.description_path(), robot.measured_joint_names)
    before, after = (kinematics.pose(q, "left_tcp", "base_link") for q in (start, end))
    np.testing.assert_allclose(after[0] - before[0], [0.01, -0.005, 0.015], rtol=0, atol=2e-6)
    turn = after[1] @ before[1].T
    np.testing.assert_allclose(np.arctan2(turn[1, 0], turn[0, 0]), 0.05, rtol=0, atol=2e-6)
    np.testing.assert_array_equal(end[8:], start[8:])


def test_where_five_joints_cannot_follow_a_delta_they_come_as_near_as_they_can() -> None:
    robot, file = load_robot("so101"), file_of("so101")
    part = next(part for part in file["parts"] if part["name"] == "arm")
    part["modes"]["cartesian_delta"]["gain"] = [1.0, 1.0]
    start = np.array([0.2, -1.0, 0.9, 0.7, 0.3, 0.3])
    delta = np.array([0.0, 0.004, 0.0, 0.0, 0.02, 0.0])
    row = {"arm": PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", delta, ())}
    prediction = Prediction(robot, file)
    prediction.damping = 0.05
    (end,) = prediction.follow(start, [row], np.array([0.0]))
    kinematics = Kinematics(robot.description_path(), robot.measured_joint_names)
    before, turned = kinematics.pose(start, "tool", "base_link")
    goal = Rotation.from_rotvec(delta[3:]) * Rotation.from_matrix(turned)

    def missing(joints: FloatArray) -> FloatArray:
        place, turn = kinematics.pose(np.append(joints, start[5]), "tool", "base_link")
        rest = (goal * Rotation.from_matrix(turn).inv()).as_rotvec()
        return np.concatenate([before + delta[:3] - place, rest])

    nearest = least_squares(missing, start[:5], xtol=1e-12, ftol=1e-12, gtol=1e-12)
    assert np.linalg.norm(missing(nearest.x)) > 1e-3
    np.testing.assert_allclose(end[:5], nearest.x, rtol=0, atol=1e-4)


@pytest.mark.parametrize(("switch", "ahead_m"), [(-1.0, 0.02), (1.0, 0.025)])
def test_with_the_switch_up_a_tool_goes_on_from_its_last_goal(
    switch: float, ahead_m: float
) -> None:
    robot, file = load_robot("panda_mobile"), file_of("panda_mobile")
    part = next(part for part in file["parts"] if part["name"] == "arm")
    part["modes"]["cartesian_delta"]["gain"] = [0.5, 0.5]
    start = np.zeros(len(robot.measured_joint_names))
    start[[robot.joint_names.index(name) for name in robot.part("arm").joints]] = [
        0.0,
        -0.4,
        0.0,
        -2.2,
        0.0,
        1.8,
        0.785,
    ]
    delta, up = np.array([0.02, 0.0, 0.0, 0.0, 0.0, 0.0]), np.array([switch])
    row = {
        "arm": PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", delta, ()),
        "composite": PartCommand(ControlMode.COMPOSITE_MODE, "", up, ()),
    }
    ends = Prediction(robot, file).follow(start, [row, row], np.zeros(2))
    kinematics = Kinematics(robot.description_path(), robot.measured_joint_names)
    tool = robot.end_effector(robot.part("arm").end_effector or "").tool_frame
    before, after = (kinematics.pose(q, tool, "base_link")[0] for q in (start, ends[-1]))
    # Half of 2 cm each; with the switch up half of the centimetre left over, too.
    np.testing.assert_allclose(after - before, [ahead_m, 0.0, 0.0], rtol=0, atol=2e-6)


def test_a_turning_twist_turns_the_base_about_base_links_origin() -> None:
    robot, file = load_robot("panda_mobile"), file_of("panda_mobile")
    part = next(part for part in file["parts"] if part["name"] == "base")
    part["modes"]["body_twist"]["gain"] = [1.0, 1.0]
    start = np.zeros(14)
    twist = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    row = {"base": PartCommand(ControlMode.BODY_TWIST, "base_link", twist, ())}
    (end,) = Prediction(robot, file).follow(start, [row], np.array([0.0]))
    # The yaw axis, 0.21 m behind the origin, swings to the right of it: by sin(0.05) 0.21 m.
    np.testing.assert_allclose(end[2], 0.05, rtol=0, atol=1e-12)
    np.testing.assert_allclose(end[1], -0.21 * np.sin(0.05), rtol=0, atol=1e-12)
    np.testing.assert_allclose(end[0], 0.21 * (1 - np.cos(0.05)), rtol=0, atol=1e-12)


@pytest.mark.parametrize(("share", "ways"), [(1.0, [0.05, 0.015, 0.0]), (0.0, [0.0, 0.0, 0.0])])
def test_what_holds_goes_on_for_its_stop_lag_and_slows_down_or_stops_at_once(
    share: float, ways: list[float]
) -> None:
    """From 1 rad/s: 60 ms of lag, then 100 rad/s^2, in ticks of 50 ms."""
    file = file_of("panda")
    file["joints"][0]["acceleration_limit"] = 100.0
    robot, now = ShareRobot(load_robot("panda"), file), still_arm()[1][0]
    robot.begin(now, np.array([[1.0, 1.0], *[[share, share]] * 3]))
    values = np.zeros(8)
    values[0] = 1.0
    row = {"arm": PartCommand(ControlMode.JOINT_VELOCITY, "", values, tuple(range(7)))}
    told = robot.step("", robot.reset(0), row)
    np.testing.assert_allclose(robot.stopped(told)[0], 0.05 + 0.06 + 0.005, rtol=0, atol=1e-12)
    after, found = told.after, []
    for _ in ways:
        before, after = after, robot.step("", after, {}).after
        found.append(after.positions[0] - before.positions[0])
    np.testing.assert_allclose(found, ways, rtol=0, atol=1e-12)
