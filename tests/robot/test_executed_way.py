"""A smooth way between rows: what the gate's file declares of it, and what is executed of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, PartRows, still
from bench.equipment.core_gate import CoreGate
from fairlead.errors import ConfigError
from fairlead.hal.interpolation import interpolator_of
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.capsule_distance import capsule_spans
from fairlead.robot.capsules import load_capsules
from fairlead.robot.description import description_tree
from fairlead.robot.executed_way import limits_for_the_gate
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.interpolation import Interpolation, smoothed_changes
from fairlead.robot.link_poses import link_poses
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.robot.safety_profile import SafetyProfile
from fairlead.robot.surroundings import Volume

PANDA = load_robot("panda")
TREE, SHAPE = description_tree(PANDA), load_capsules(PANDA)
DECLARED = PANDA.profile("sim")
ARM, STEP = tuple(range(7)), 0.055
PER_PERIOD = 25  # a drive of 500 Hz
SWEEP_M = 0.005
"""Between two configurations that the gate looks at, a distance may be so far below its limit."""
POST_M = 0.004


def smooth(robot: RobotManifest) -> RobotManifest:
    return robot.model_copy(update={"interpolation": "cubic_b_spline"})


def gates(robot: RobotManifest) -> SafetyProfile:
    return limits_for_the_gate(robot, "sim", TREE, SHAPE)


def test_the_gates_limits_have_the_lag_and_the_deviation_of_a_smooth_way() -> None:
    assert gates(PANDA) == DECLARED
    found = gates(smooth(PANDA))
    arm, declared = found.parts["arm"].joint_position, DECLARED.parts["arm"].joint_position
    assert arm is not None and declared is not None
    more = np.subtract(arm.tracking_limits, declared.tracking_limits)
    np.testing.assert_allclose(more, np.multiply(declared.step_limits, 7 / 6), rtol=0, atol=1e-6)
    period_s = PANDA.tick_period_ns * 1e-9
    for name in PANDA.joint_names:
        lag, before = found.measured[name].stop_lag_s, DECLARED.measured[name].stop_lag_s
        assert lag is not None and before is not None
        assert lag == pytest.approx(before + period_s)
    ramp = found.protocol.stop_ramp_ms - DECLARED.protocol.stop_ramp_ms
    assert ramp == 2 * PANDA.control_period_ms


def test_no_joint_beside_its_way_moves_a_shape_further_than_the_gate_keeps_clear() -> None:
    """Each joint off by a sixth of what is smoothed, in all directions, wherever the arm is."""
    rng = np.random.default_rng(7)
    changes, found = smoothed_changes(PANDA, "sim"), gates(smooth(PANDA))
    count = 400
    at = {
        one.name: rng.uniform(one.lower, one.upper, count)
        for one in (*PANDA.joints, *PANDA.passive_joints)
    }
    off = {
        name: q + rng.choice([-1, 1], count) * changes.get(name, 0.0) / 6 for name, q in at.items()
    }
    ends = [np.array(capsule_spans(SHAPE.capsules, link_poses(TREE, q))) for q in (at, off)]
    moved = float(np.linalg.norm(ends[1] - ends[0], axis=-1).max())
    assert 0.3 * moved < moved < found.workspace.margin_m - DECLARED.workspace.margin_m


def test_another_way_between_rows_is_another_robot() -> None:
    assert smooth(PANDA).robot_hash != PANDA.robot_hash


def test_a_mobile_base_has_none() -> None:
    with pytest.raises(ConfigError) as error:
        compile_gate_config(smooth(load_robot("panda_mobile")), "sim")
    wanted = (
        "robot panda_mobile: interpolation of a mobile base: expected linear, got cubic_b_spline"
    )
    assert str(error.value) == wanted


@contextmanager
def gate_with_post(
    robot: RobotManifest, where: FloatArray, folder: Path
) -> Iterator[CoreGate | None]:
    """The real gate, of a robot that has to keep clear of a small thing; None: home is there."""
    post = Volume(
        name="post",
        kind="keep_out",
        lower_m=tuple(where - POST_M),
        upper_m=tuple(where + POST_M),
    )
    workspace = DECLARED.workspace.model_copy(
        update={"volumes": (*DECLARED.workspace.volumes, post)}
    )
    safety = {"sim": DECLARED.model_copy(update={"workspace": workspace})}
    path = folder / "gate.json"
    path.write_text(compile_gate_config(robot.model_copy(update={"safety": safety}), "sim"))
    gate = CoreGate(path)
    try:
        yield gate
    finally:
        gate.close()


def released(gate: CoreGate, start: FloatArray, rows: FloatArray) -> int:
    """How many of these rows of joint targets the gate lets through."""
    positions = np.concatenate([start, [0.04, 0.02, -0.02]])
    values = np.hstack([rows, np.zeros((len(rows), 1))])
    part = PartRows(0, ControlMode.JOINT_POSITION, values, active=ARM)
    chunk = Chunk(10, len(rows), (part,))
    (answer,) = gate.answers(Case("panda", "lockstep", still(10, positions), chunk))
    return 0 if answer.safe is None else answer.safe.horizon


def executed(robot: RobotManifest, start: FloatArray, rows: FloatArray) -> FloatArray:
    """What a drive is told until it stands, ``[n, 7]``, by the HAL's own code."""
    interpolator = interpolator_of(robot, "sim")
    interpolator.restart(np.append(start, 0.04))
    told = []
    for row in [*rows, *[rows[-1]] * 3]:
        way = interpolator.advance(np.append(row, 0.04))
        told += [way(step / PER_PERIOD)[:7] for step in range(1, PER_PERIOD + 1)]
    return np.array(told)


def distance(way: FloatArray, where: FloatArray) -> float:
    """The arm's smallest from the post [m]: of many points of each capsule, and of the tool."""
    count = len(way)
    fixed = {"panda_gripper": 0.04, "panda_finger_joint1": 0.02, "panda_finger_joint2": -0.02}
    at = {name: np.full(count, value) for name, value in fixed.items()}
    at |= {name: way[:, i] for i, name in enumerate(PANDA.joint_names[:7])}
    poses = link_poses(TREE, at)
    found = []
    for (a, b), capsule in zip(capsule_spans(SHAPE.capsules, poses), SHAPE.capsules, strict=True):
        if capsule.link == TREE.root:
            continue
        points = a[:, None] + np.linspace(0.0, 1.0, 60)[:, None] * (b - a)[:, None]
        off = np.maximum(np.abs(points - where) - POST_M, 0.0)
        found.append(float(np.linalg.norm(off, axis=-1).min()) - capsule.radius_m)
    return min(found)


def bent_rows(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """A way with one corner: there and away at nearly the largest step."""
    start = np.array([0.0, 0.2, 0.0, -1.8, 0.0, 2.0, 0.8]) + rng.uniform(-0.3, 0.3, 7)
    one, other = 0.95 * STEP * rng.choice([-1.0, 1.0], (2, 7))
    return start, start + np.cumsum([one] * 3 + [other] * 3, axis=0)


def nearest_post(
    robot: RobotManifest, start: FloatArray, rows: FloatArray, side: FloatArray, folder: Path
) -> FloatArray:
    """Where, on a line away from the corner, a thing is that the gate still lets rows pass by."""
    near, far = 0.0, 0.5
    tool = link_poses(TREE, _at(rows[2]))["panda_hand"].translation[0]
    for _ in range(9):
        middle = 0.5 * (near + far)
        with gate_with_post(robot, tool + middle * side, folder) as gate:
            assert gate is not None
            passes = released(gate, start, rows) == len(rows)
        near, far = (near, middle) if passes else (middle, far)
    return np.asarray(tool + far * side)


def _at(q: FloatArray) -> dict[str, FloatArray]:
    values = {name: np.array([q[i]]) for i, name in enumerate(PANDA.joint_names[:7])}
    return values | {name: np.zeros(1) for name in ("panda_gripper", *PANDA.passive_joint_names)}


@pytest.mark.parametrize("interpolation", ["cubic_b_spline", "linear"])
def test_what_is_executed_keeps_clear_by_what_is_declared(
    interpolation: Interpolation, tmp_path: Path
) -> None:
    """Things as near the inside of a corner as the gate lets rows pass, at random.

    A gate whose file is made for the straight way lets them pass nearer: the smooth way comes
    nearer to some than is declared. So the test can tell.
    """
    rng = np.random.default_rng(3)
    judged = PANDA.model_copy(update={"interpolation": interpolation})
    nearest = np.inf
    for _ in range(8):
        start, rows = bent_rows(rng)
        before, corner, after = (
            link_poses(TREE, _at(q))["panda_hand"].translation[0] for q in rows[[1, 2, 3]]
        )
        side = before - 2.0 * corner + after
        side = side / np.linalg.norm(side)
        post = nearest_post(judged, start, rows, side, tmp_path)
        nearest = min(nearest, distance(executed(smooth(PANDA), start, rows), post))
    kept = nearest - DECLARED.workspace.margin_m
    assert kept >= -SWEEP_M if interpolation == "cubic_b_spline" else kept < 0.0, kept
