"""Capsules around pieces: nothing sticks out, little room is left, and always the same ones."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.messages import FloatArray
from fairlead_tools.shape.convex_part import ConvexPart, box, capsule, cylinder
from fairlead_tools.shape.fit import Fitted, _main_axes, fit_capsules, sticking_out

ROTATION = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
SHIFT = np.array([0.3, -0.1, 0.7])


def reaching_out(points: FloatArray, capsules: list[Fitted]) -> float:
    """How far the worst point is out of all capsules, written without the code under test."""
    worst = -np.inf
    for point in points:
        depths = []
        for one in capsules:
            share = np.linspace(0.0, 1.0, 2001)[:, None]
            axis = one.a + share * (one.b - one.a)
            depths.append(np.linalg.norm(axis - point, axis=1).min() - one.radius)
        worst = max(worst, min(depths))
    return worst


def box_points(half: FloatArray, count: int = 400) -> FloatArray:
    """Corners, and points on the surface."""
    rng = np.random.default_rng(5)
    points = rng.uniform(-1.0, 1.0, (count, 3))
    points[np.arange(count), rng.integers(0, 3, count)] = rng.choice([-1.0, 1.0], count)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return np.concatenate([corners, points]) * half


def test_a_capsule_is_found_again_wherever_it_lies() -> None:
    (fit,) = fit_capsules([capsule(0.05, 0.2).placed(ROTATION, SHIFT)], 3)
    ends = sorted([fit.a.tolist(), fit.b.tolist()])
    wanted = sorted((ROTATION @ [0.0, 0.0, z] + SHIFT).tolist() for z in (-0.2, 0.2))
    np.testing.assert_allclose(ends, wanted, atol=2e-3)
    assert 0.05 <= fit.radius < 0.0515


def test_a_ball_becomes_a_ball() -> None:
    (fit,) = fit_capsules([capsule(0.03, 0.0)], 1)
    assert np.linalg.norm(fit.b - fit.a) < 1e-3
    assert 0.03 <= fit.radius < 0.0305


@pytest.mark.parametrize("half", [[0.02, 0.03, 0.3], [0.1, 0.1, 0.1], [0.2, 0.15, 0.01]])
def test_all_of_a_box_lies_in_its_capsule(half: list[float]) -> None:
    sizes = np.array(half)
    capsules = fit_capsules([box(sizes).placed(ROTATION, SHIFT)], 1)
    assert reaching_out(box_points(sizes) @ ROTATION.T + SHIFT, capsules) <= 1e-6


def test_the_capsule_of_a_long_box_is_hardly_wider_than_it_must_be() -> None:
    (fit,) = fit_capsules([box(np.array([0.03, 0.04, 0.5]))], 1)
    # Around the box's own axis: half the diagonal of its section, the ends on the corners.
    assert 0.05 <= fit.radius < 0.0525
    assert fit.volume < 1.02 * np.pi * 0.05**2 * (1.0 + 4.0 / 3.0 * 0.05)


def test_a_round_edge_lies_inside_too() -> None:
    capsules = fit_capsules([cylinder(0.09, 0.07)], 1)
    turns = np.linspace(0.0, 2.0 * np.pi, 1000)
    rims = [np.stack([0.09 * np.cos(turns), 0.09 * np.sin(turns), 0.0 * turns + z], axis=1)
            for z in (-0.07, 0.07)]  # fmt: skip
    assert reaching_out(np.concatenate(rims), capsules) <= 1e-9


def test_a_wide_box_gets_several_capsules_that_cover_it_together() -> None:
    sizes = np.array([0.35, 0.25, 0.19])
    one, several = fit_capsules([box(sizes)], 1), fit_capsules([box(sizes)], 3)
    assert len(several) > 1
    assert reaching_out(box_points(sizes, 1500), several) <= 1e-6

    def front(capsules: list[Fitted]) -> float:
        return max(float(max(c.a[0], c.b[0])) + c.radius for c in capsules)

    assert front(several) < front(one) - 0.1


def test_pieces_far_apart_get_a_capsule_each() -> None:
    still = np.eye(3)
    pieces = [capsule(0.05, 0.1), capsule(0.05, 0.1).placed(still, np.array([1.0, 0.0, 0.0]))]
    fits = fit_capsules(pieces, 4)
    assert [fit.radius for fit in fits] == pytest.approx([0.05, 0.05], abs=2e-3)
    assert len(fit_capsules(pieces, 1)) == 1


def test_the_same_pieces_give_the_same_capsules() -> None:
    pieces = [box(np.array([0.1, 0.2, 0.3])).placed(ROTATION, SHIFT), cylinder(0.1, 0.4)]
    first, second = fit_capsules(pieces, 3), fit_capsules(pieces, 3)
    for one, other in zip(first, second, strict=True):
        assert (one.a.tolist(), one.b.tolist()) == (other.a.tolist(), other.b.tolist())
        assert one.radius == other.radius


@pytest.mark.parametrize("piece", [box(np.array([0.1, 0.2, 0.3])), cylinder(0.1, 0.3)])
def test_both_sides_of_a_cut_hold_all_of_a_piece_and_no_more(piece: ConvexPart) -> None:
    normal = np.array([0.6, 0.0, 0.8])
    parts = piece.cut(normal, 0.05)
    directions = np.random.default_rng(6).normal(size=(300, 3))
    whole = (directions @ piece.points.T).max(axis=1)
    reach = [(directions @ part.points.T).max(axis=1) for part in parts if part is not None]
    assert len(reach) == 2
    np.testing.assert_allclose(np.max(reach, axis=0), whole, atol=1e-12)
    below, above = parts
    assert below is not None
    assert above is not None
    assert (below.points @ normal).max() == pytest.approx(0.05, abs=1e-12)
    assert (above.points @ normal).min() == pytest.approx(0.05, abs=1e-12)


def test_a_cut_beside_a_piece_leaves_it_whole() -> None:
    piece = box(np.array([0.1, 0.1, 0.1]))
    assert piece.cut(np.array([0.0, 0.0, 1.0]), 0.1) == (piece, None)
    assert piece.cut(np.array([0.0, 0.0, 1.0]), -0.2) == (None, piece)


def test_a_piece_can_be_cut_twice() -> None:
    quarter: ConvexPart | None = box(np.array([1.0, 1.0, 1.0]))
    for normal in np.eye(3)[:2]:
        assert quarter is not None
        quarter = quarter.cut(normal, 0.0)[0]
    assert quarter is not None
    corners = {tuple(point) for point in np.round(quarter.points, 9).tolist()}
    assert corners == {(x, y, z) for x in (-1, 0) for y in (-1, 0) for z in (-1, 1)}


def test_a_gap_between_two_capsules_is_found_where_no_corner_lies() -> None:
    piece, radius = box(np.array([0.1, 0.1, 0.5])), 0.2
    ends = [
        Fitted(np.array([0.0, 0.0, low]), np.array([0.0, 0.0, low + 0.45]), radius)
        for low in (-0.5, 0.05)
    ]
    assert sticking_out(piece, ends) <= 0.0
    # Balls that hold the corners only: half-way, an edge is 0.52 m from both middles.
    balls = [Fitted(end, end, radius) for end in np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]])]
    assert sticking_out(piece, balls) == pytest.approx(np.hypot(0.5, np.hypot(0.1, 0.1)) - radius)
    assert sticking_out(piece, []) == np.inf


def test_a_mesh_of_many_points_needs_little_memory() -> None:
    points = np.random.default_rng(0).normal(size=(100_000, 3)) * [0.3, 0.1, 0.1]
    (longest, *_) = _main_axes(points)  # all points by all points would be 75 GiB
    assert np.abs(longest).argmax() == 0
