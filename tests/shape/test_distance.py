"""Distances between capsules against coal's, a collision library of its own."""

from __future__ import annotations

import coal
import numpy as np
import pytest

from fairlead.messages import FloatArray
from fairlead.robot.capsule_distance import segment_distance

COUNT = 3000
TOLERANCE_M = 1e-6
Ends = tuple[FloatArray, FloatArray]


def placed(a: FloatArray, b: FloatArray) -> coal.Transform3s:
    """The pose of coal's capsule, which lies along its own z around its middle."""
    along = b - a
    z = along / np.linalg.norm(along)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return coal.Transform3s(np.column_stack([x, np.cross(z, x), z]), (a + b) / 2.0)


def coals(first: Ends, second: Ends, radii: FloatArray) -> float:
    shapes = [
        coal.Capsule(radius, float(np.linalg.norm(ends[1] - ends[0])))
        for ends, radius in zip((first, second), radii, strict=True)
    ]
    poses = [placed(*ends) for ends in (first, second)]
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return float(coal.distance(shapes[0], poses[0], shapes[1], poses[1], request, result))


def random_ends(rng: np.random.Generator, count: int) -> Ends:
    middle = rng.uniform(-0.5, 0.5, (count, 3))
    half = rng.normal(size=(count, 3)) * rng.uniform(0.005, 0.3, (count, 1))
    return middle - half, middle + half


def test_random_capsules_are_as_far_apart_as_coal_says() -> None:
    rng = np.random.default_rng(3)
    first, second = random_ends(rng, COUNT), random_ends(rng, COUNT)
    radii = rng.uniform(0.005, 0.1, (COUNT, 2))
    ours = segment_distance(*first, *second) - radii.sum(axis=1)
    theirs = [
        coals((first[0][i], first[1][i]), (second[0][i], second[1][i]), radii[i])
        for i in range(COUNT)
    ]
    # Both kinds have to be among them, or half of this says nothing.
    assert 0.02 < np.mean(np.array(theirs) < 0.0) < 0.98
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=TOLERANCE_M)


def test_nearly_parallel_capsules_too() -> None:
    rng = np.random.default_rng(4)
    a, b = random_ends(rng, 500)
    shift = rng.normal(size=(500, 3)) * 0.2
    tilt = rng.normal(size=(500, 3)) * 10.0 ** rng.uniform(-12, -3, (500, 1))
    ours = segment_distance(a, b, a + shift, b + shift + tilt)
    theirs = [
        coals((a[i], b[i]), (a[i] + shift[i], b[i] + shift[i] + tilt[i]), np.full(2, 0.01))
        for i in range(500)
    ]
    np.testing.assert_allclose(ours - 0.02, theirs, rtol=0.0, atol=TOLERANCE_M)


@pytest.mark.parametrize(
    ("second", "distance"),
    [
        (([0.5, -1, 2], [0.5, 1, 2]), 2.0),  # crossing: between the feet of both lines
        (([3, 0, 0], [5, 0, 0]), 2.0),  # in line: end to end
        (([0.25, 0, 3], [0.75, 0, 3]), 3.0),  # parallel, beside each other
        (([0.5, 0, 0.5], [0.5, 0, 0.5]), 0.5),  # a ball
        (([1, 1, 0], [1, 4, 0]), 1.0),  # end to side
        (([0.2, -1, 0], [0.2, 1, 0]), 0.0),  # through it
    ],
)
def test_distances_by_hand(second: tuple[list[float], list[float]], distance: float) -> None:
    first = np.array([[0.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    c, d = (np.array([end], dtype=float) for end in second)
    assert segment_distance(*first, c, d) == pytest.approx([distance], abs=1e-12)
    assert segment_distance(c, d, *first) == pytest.approx([distance], abs=1e-12)


def test_a_position_that_is_no_number_gives_a_distance_that_is_none() -> None:
    point = np.zeros((1, 3))
    assert np.isnan(segment_distance(point, point * np.nan, point, point + 1.0)).all()
