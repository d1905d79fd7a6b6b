"""The gate's distances, damped least squares and singular values, against coal and pinocchio."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest

from fairlead.messages import FloatArray
from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot
from tests.gate.joint_samples import samples
from tests.gate.pinocchio_tool import (
    HARDLY,
    PinocchioTool,
    damped,
    motion_between,
    moved,
    probe,
)

pytestmark = pytest.mark.processes

MOST_BEND, LEAST_BEND = 0.2, 2e-3


def hard_segments(count: int) -> FloatArray:
    """Ends of pairs of segments [count, 4, 3]: any, parallel, crossing, touching, of no length."""
    rng = np.random.default_rng(11)
    ends = rng.uniform(-1.0, 1.0, (count, 4, 3))
    kind = np.arange(count) % 8
    along = ends[:, 1] - ends[:, 0]
    parallel = (kind == 1) | (kind == 2)
    shift = rng.uniform(-2.0, 2.0, (count, 1))
    tilt = np.where(kind == 2, 10.0 ** rng.uniform(-12, -3, count), 0.0)[:, None]
    near = ends[:, 2] + shift * along + tilt * rng.uniform(-1.0, 1.0, (count, 3))
    ends[parallel, 3] = near[parallel]
    one, other = rng.uniform(0.0, 1.0, (2, count, 1))
    crossing = ends[:, 0] + one * along  # a point of the first, on the second as well
    ends[kind == 3, 3] = (ends[:, 2] + (crossing - ends[:, 2]) / other)[kind == 3]
    ends[kind == 4, 2] = ends[kind == 4, 1]  # end to end
    ends[kind == 5, 3] = ends[kind == 5, 2]  # a point
    ends[kind == 6, 1] = ends[kind == 6, 0]
    ends[kind == 7, 1], ends[kind == 7, 3] = ends[kind == 7, 0], ends[kind == 7, 2]
    return ends


def coal_capsule(
    a: FloatArray, b: FloatArray, radius: float
) -> tuple[coal.Capsule, coal.Transform3s]:
    """A capsule's shape and where it is."""
    length = float(np.linalg.norm(b - a))
    axis = (b - a) / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis).toRotationMatrix()
    return coal.Capsule(radius, length), coal.Transform3s(turn, 0.5 * (a + b))


@pytest.mark.parametrize(
    "count", [2_000, pytest.param(40_000, marks=pytest.mark.soak)], ids=["short", "long"]
)
def test_capsules_are_as_far_apart_as_coal_says(count: int) -> None:
    ends = hard_segments(count)
    radii = np.random.default_rng(12).uniform(0.01, 0.2, (count, 2))
    ours = probe(ends, "segments") - radii.sum(axis=1)
    request = coal.DistanceRequest()
    request.gjk_tolerance = 1e-9
    worst, compared = 0.0, 0
    for (a, b, c, d), (r, s), distance in zip(ends, radii, ours, strict=True):
        if distance < 1e-3:
            continue  # overlapping: coal then tells a depth, by an approximation of its own
        result = coal.DistanceResult()
        shape, place = coal_capsule(a, b, r)
        other, other_place = coal_capsule(c, d, s)
        theirs = coal.distance(shape, place, other, other_place, request, result)
        worst = max(worst, abs(distance - theirs))
        compared += 1
    assert compared > count // 2
    assert worst <= 1e-6


def test_segments_are_no_nearer_anywhere_than_the_gate_says() -> None:
    ends = hard_segments(400)
    ours = probe(ends, "segments")
    share = np.linspace(0.0, 1.0, 101)[:, None]
    for (a, b, c, d), distance in zip(ends, ours, strict=True):
        gaps = (a + share * (b - a))[:, None] - (c + share * (d - c))[None]
        sampled = float(np.linalg.norm(gaps, axis=2).min())
        step = 0.01 * (np.linalg.norm(b - a) + np.linalg.norm(d - c))
        assert distance - 1e-9 <= sampled <= distance + step


def test_segments_are_as_far_from_boxes_as_coal_says() -> None:
    rng = np.random.default_rng(13)
    segments = rng.uniform(-1.0, 1.0, (2000, 2, 3))
    lower = rng.uniform(-1.0, 0.5, (2000, 3))
    upper = lower + rng.uniform(0.05, 0.8, (2000, 3))
    ours = probe(np.hstack([segments.reshape(-1, 6), lower, upper]), "boxes")
    request, compared = coal.DistanceRequest(), 0
    request.gjk_tolerance = 1e-9
    for (a, b), low, high, distance in zip(segments, lower, upper, ours, strict=True):
        if distance < 0.02:
            continue
        shape, place = coal_capsule(a, b, 0.01)
        middle = coal.Transform3s(np.eye(3), 0.5 * (low + high))
        result = coal.DistanceResult()
        theirs = coal.distance(shape, place, coal.Box(high - low), middle, request, result) + 0.01
        assert abs(distance - theirs) <= 1e-6
        compared += 1
    assert compared > 500


@pytest.mark.parametrize(
    ("name", "part"),
    [("panda_mobile", "arm"), ("dual_panda", "left_arm"), ("dual_panda", "right_arm")],
)
def test_damped_least_squares_and_singular_values_are_those_of_pinocchio(
    name: str, part: str
) -> None:
    robot, config = load_robot(name), gate_config(name, "sim")
    tool, count = PinocchioTool(robot, part), 1000
    positions, _ = samples(robot, count)
    motions = np.random.default_rng(5).uniform(-0.05, 0.05, (count, 6))
    answers = probe(np.hstack([positions, motions]), "tool", config, part)
    answers = answers.reshape(count, 8 + positions.shape[1])
    solved = 0
    for row, motion, answer in zip(positions, motions, answers, strict=True):
        jacobian, start = tool.seen(row)
        assert abs(answer[7] - np.linalg.svd(jacobian, compute_uv=False).min()) <= 1e-6
        after, has_ended = tool.stepped(row, motion)
        assert np.abs(answer[8:] - after).max() <= 1e-6
        made = motion_between(start, tool.seen(after)[1])
        assert np.abs(answer[:6] - made).max() <= 1e-7
        missed = np.linalg.norm(motion_between(tool.seen(after)[1], moved(start, motion)))
        straight = damped(jacobian, motion, HARDLY)
        bend = np.abs(after[tool.own] - row[tool.own] - straight).max()
        to_spare = MOST_BEND * np.abs(straight).max() + LEAST_BEND - bend
        if min(abs(missed - np.linalg.norm(motion)), abs(to_spare)) > 1e-6:
            ends = has_ended and to_spare > 0.0
            assert (answer[6] == 1.0) == (ends and missed < np.linalg.norm(motion))
        solved += int(answer[6] == 1.0)
    assert 0.4 * count < solved < 0.9 * count
