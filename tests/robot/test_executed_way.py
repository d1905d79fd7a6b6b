"""A smooth way between rows: what the gate's file declares of it, and what is executed of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, PartRows, still
from bench.equipment.core_gate import CoreGate
from fairlead.errors import ConfigError
from fairlead.hal.identity import identity_of
from fairlead.hal.interpolation import interpolator_of
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.capsule_distance import capsule_spans
from fairlead.robot.capsules import load_capsules
from fairlead.robot.description import description_tree
from fairlead.robot.executed_way import limits_for_the_gate, smoothed_changes
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.link_poses import link_poses
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.robot.safety_profile import SafetyProfile
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend

PANDA = load_robot("panda")
TREE, SHAPE = description_tree(PANDA), load_capsules(PANDA)
DECLARED = PANDA.profile("sim")
ARM, STEP = tuple(range(7)), 0.055
PER_PERIOD = 25  # a drive of 500 Hz
SWEEP_M = 0.005
"""Between two configurations that the gate looks at, a distance may be so far below its limit."""


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
    assert str(error.value) == (
        "robot panda_mobile: interpolation of a mobile base: expected linear, got cubic_b_spline"
    )


def test_a_hal_with_another_way_between_rows_is_refused() -> None:
    backend = MujocoBackend(PANDA)
    identity_of(PANDA, "sim", "arm").check(backend.describe())
    with pytest.raises(ConfigError) as error:
        identity_of(smooth(PANDA), "sim", "arm").check(backend.describe())
    assert str(error.value) == (
        "hal of arm: expected interpolation cubic_b_spline as in robot.yaml, got linear"
    )


@contextmanager
def gate_with_wall(robot: RobotManifest, wall_m: float, folder: Path) -> Iterator[CoreGate]:
    """The real gate of a robot whose tool has to stay below a height."""
    box = DECLARED.workspace.volumes[0]
    box = box.model_copy(update={"upper_m": (*box.upper_m[:2], wall_m)})
    workspace = DECLARED.workspace.model_copy(update={"volumes": (box,)})
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
    values = np.hstack([rows, np.zeros((len(rows), 1))])
    part = PartRows(0, ControlMode.JOINT_POSITION, values, active=ARM)
    measured = still(10, np.concatenate([start, [0.04, 0.02, -0.02]]))
    (answer,) = gate.answers(Case("panda", "lockstep", measured, Chunk(10, len(rows), (part,))))
    return 0 if answer.safe is None else answer.safe.horizon


def executed(start: FloatArray, rows: FloatArray) -> FloatArray:
    """What a drive is told until it stands, ``[n, 7]``, by the HAL's own code."""
    interpolator = interpolator_of(smooth(PANDA), "sim")
    interpolator.restart(np.append(start, 0.04))
    told = []
    for row in [*rows, *[rows[-1]] * 3]:
        way = interpolator.advance(np.append(row, 0.04))
        told += [way(step / PER_PERIOD)[:7] for step in range(1, PER_PERIOD + 1)]
    return np.array(told)


def straight(start: FloatArray, rows: FloatArray) -> FloatArray:
    """The gate's way a period later, and standing at its end, as long as the executed one."""
    places = np.arange(1, PER_PERIOD + 1)[:, None] / PER_PERIOD
    ways = pairwise([start, start, *rows, rows[-1], rows[-1]])
    return np.concatenate([before + places * (row - before) for before, row in ways])


def heights(way: FloatArray) -> FloatArray:
    """Of the tool [m]."""
    at = {name: np.zeros(len(way)) for name in ("panda_gripper", *PANDA.passive_joint_names)}
    at |= {name: way[:, i] for i, name in enumerate(PANDA.joint_names[:7])}
    return link_poses(TREE, at)[PANDA.end_effectors[0].tool_frame].translation[:, 2]


@pytest.mark.processes
def test_the_executed_way_of_accepted_rows_is_within_what_the_gate_certified(
    tmp_path: Path,
) -> None:
    """Random rows with corners under a ceiling at random heights, judged by the real gate.

    What it releases is beside its own straight way by no more than its file has room for, and stays
    below the ceiling by the margin of robot.yaml. A gate whose file is made for the straight way
    lets rows pass for which there is no such room.
    """
    rng, margin = np.random.default_rng(3), DECLARED.workspace.margin_m
    most = np.array(list(smoothed_changes(PANDA, "sim").values())[:7]) / 6.0
    without_room, left = 0, []
    for _ in range(30):
        start = np.array([0.0, 0.2, 0.0, -1.8, 0.0, 2.0, 0.8]) + rng.uniform(-0.3, 0.3, 7)
        steps = STEP * rng.choice([-1.0, 0.0, 1.0], (3, 7)).repeat(2, axis=0)
        rows = start + np.cumsum(steps, axis=0)
        ceiling = float(heights(straight(start, rows)).max() + rng.uniform(0.0, 0.04))
        count = {}
        for robot in (PANDA, smooth(PANDA)):
            with gate_with_wall(robot, ceiling, tmp_path) as gate:
                count[robot.interpolation] = released(gate, start, rows)
        assert count["cubic_b_spline"] <= count["linear"]
        without_room += count["cubic_b_spline"] < count["linear"]
        if count["cubic_b_spline"]:
            rows = rows[: count["cubic_b_spline"]]
            way = executed(start, rows)
            assert (np.abs(way - straight(start, rows)) <= most + 1e-12).all()
            left.append(ceiling - heights(way).max())
    assert without_room > 3
    assert len(left) > 3
    assert min(left) >= margin - SWEEP_M
