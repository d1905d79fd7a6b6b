"""Capsules around the pieces of a link: each piece lies in their union, with little room left.

The search is random with a fixed seed: the same pieces give the same capsules.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fairlead.messages import FloatArray
from fairlead_tools.shape.convex_part import ConvexPart

_GRID_M = 1e-4  # capsules are told to a tenth of a millimetre
_TRIES = 48  # candidates of one round of the search
_ROUGH, _FINE = 12, 90  # rounds
_TOO_FAR_M = 0.1
_WORTH_IT, _WORTH_IT_FAR_OUT = (
    0.6,
    0.95,
)  # one capsule more has to leave at most this share of the cost
_DIRECTIONS = np.random.default_rng(1).normal(size=(200, 3))
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)  # where a rough fit looks
_SHARES = (0.2, 0.35, 0.5, 0.65, 0.8)  # of a link's length: where it may be cut


@dataclass(frozen=True)
class Fitted:
    """A capsule: all points within ``radius`` of the segment from ``a`` to ``b`` [m]."""

    a: FloatArray
    b: FloatArray
    radius: float

    @property
    def volume(self) -> float:
        """[m3]."""
        length = float(np.linalg.norm(self.b - self.a))
        return math.pi * self.radius**2 * (length + 4.0 / 3.0 * self.radius)

    def excesses(self, points: FloatArray, radius: float) -> FloatArray:
        """How far a ball around each of the points ``[n, 3]`` reaches out of the capsule [m]."""
        along = self.b - self.a
        length2 = float(along @ along)
        share = (points - self.a) @ along / length2 if length2 > 0.0 else np.zeros(len(points))
        nearest = self.a + np.clip(share, 0.0, 1.0)[:, None] * along
        return np.asarray(np.linalg.norm(points - nearest, axis=1) + (radius - self.radius))

    def excess(self, piece: ConvexPart) -> float:
        """How far a piece reaches out of the capsule [m]; at most 0 where it lies inside."""
        return float(self.excesses(piece.points, piece.radius).max())


def fit_capsules(pieces: Sequence[ConvexPart], most: int) -> list[Fitted]:
    """At most ``most`` capsules that cover the pieces together, one where one is good enough."""
    groups = [list(pieces)]
    fits = [_fit(groups[0], _ROUGH)]
    reach = np.max([_reach(piece.points, piece.radius) for piece in pieces], axis=0)
    while len(groups) < most:
        ways = []
        for index, group in enumerate(groups):
            for halves in _cuts(group):
                others = fits[:index] + fits[index + 1 :]
                cost = _cost([*others, *(_fit(half, _ROUGH) for half in halves)], reach)
                ways.append((cost, index, halves))
        cost, index, halves = min(ways, key=lambda way: way[0], default=(math.inf, 0, ([], [])))
        worth = _WORTH_IT if _excess(fits, reach) < _TOO_FAR_M else _WORTH_IT_FAR_OUT
        if cost >= worth * _cost(fits, reach):
            break
        groups[index : index + 1] = halves
        fits[index : index + 1] = [_fit(half, _ROUGH) for half in halves]
    return [_on_grid(_fit(group, _FINE), group) for group in groups]


def _cost(fits: list[Fitted], reach: FloatArray) -> float:
    """Volume of capsules, times how far they stick out of what reaches so far [m4]."""
    return sum(fit.volume for fit in fits) * _excess(fits, reach)


def _excess(fits: list[Fitted], reach: FloatArray) -> float:
    own = [_reach(np.stack([fit.a, fit.b]), fit.radius) for fit in fits]
    return float((np.max(own, axis=0) - reach).max())


def _reach(points: FloatArray, radius: float) -> FloatArray:
    """How far a convex body reaches in each direction we look, shape ``[200]`` [m]."""
    return np.asarray((_DIRECTIONS @ points.T).max(axis=1) + radius)


def _cuts(pieces: list[ConvexPart]) -> list[tuple[list[ConvexPart], list[ConvexPart]]]:
    """Ways to part the pieces by a plane."""
    points = np.concatenate([piece.points for piece in pieces])
    found = []
    for normal in [*np.eye(3), *_main_axes(points)]:
        heights = points @ normal
        low, high = float(heights.min()), float(heights.max())
        offsets = [low + share * (high - low) for share in _SHARES]
        for piece in pieces if len(pieces) > 1 else ():
            own = piece.points @ normal
            offsets += [float(own.min()) - piece.radius, float(own.max()) + piece.radius]
        for offset in offsets:
            parts = [piece.cut(normal, offset) for piece in pieces]
            below = [part for part, _ in parts if part is not None]
            above = [part for _, part in parts if part is not None]
            if below and above:
                found.append((below, above))
    return found


def _main_axes(points: FloatArray) -> FloatArray:
    """Principal axes as rows ``[3, 3]``, the longest first, the same sign on every machine."""
    few = len(points) < 3  # else a matrix of all points by all points would be made too
    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=few)[2]
    signs = np.sign(axes[np.arange(3), np.argmax(np.abs(axes), axis=1)])
    return np.asarray(axes * signs[:, None], dtype=np.float64)


def _fit(pieces: list[ConvexPart], rounds: int) -> Fitted:
    """One capsule around all pieces, of nearly the least volume."""
    balls = np.concatenate(
        [np.column_stack([p.points, np.full(len(p.points), p.radius)]) for p in pieces]
    )
    if rounds == _ROUGH:
        balls = balls[np.unique(np.argmax(_DIRECTIONS @ balls[:, :3].T, axis=1))]
    middle = (balls[:, :3].min(axis=0) + balls[:, :3].max(axis=0)) / 2.0
    size = float(np.abs(balls[:, :3] - middle).max() + balls[:, 3].max())
    rng = np.random.default_rng(0)
    tries = np.array(
        [[*axis, 0.0, 0.0, 0.0, 0.0] for axis in [*np.eye(3), *_main_axes(balls[:, :3])]]
    )
    best, least, step = tries[0], math.inf, 0.3
    for _ in range(rounds):
        volumes = _candidates(tries, balls, middle, size)[3]
        first = int(np.argmin(volumes))
        step *= 1.1 if volumes[first] < least else 0.8
        if volumes[first] < least:
            best, least = tries[first], float(volumes[first])
        tries = best + step * rng.normal(size=(_TRIES, 7))
        tries[:, 6] = np.abs(tries[:, 6])
    a, b, radius, _ = (value[0] for value in _candidates(best[None], balls, middle, size))
    return Fitted(a, b, float(radius))


def _candidates(
    tries: FloatArray, balls: FloatArray, middle: FloatArray, size: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """The tightest capsule of each try: ends ``[k, 3]``, radii and volumes ``[k]``.

    A try ``[7]`` is a direction, a point near the middle (in units of the size), and by what
    share the radius is larger than it must be, which lets the ends come nearer.
    """
    axes = tries[:, :3] / np.linalg.norm(tries[:, :3], axis=1, keepdims=True)
    starts = middle + size * tries[:, 3:6]
    rays = balls[None, :, :3] - starts[:, None, :]
    along = np.einsum("kni,ki->kn", rays, axes)
    aside = np.sqrt(np.maximum(np.einsum("kni,kni->kn", rays, rays) - along**2, 0.0))
    radii = (aside + balls[:, 3]).max(axis=1) * (1.0 + tries[:, 6])
    reach = np.sqrt(np.maximum((radii[:, None] - balls[:, 3]) ** 2 - aside**2, 0.0))
    low, high = (along + reach).min(axis=1), (along - reach).max(axis=1)
    low, high = np.minimum(low, (low + high) / 2.0), np.maximum(high, (low + high) / 2.0)
    volumes = np.pi * radii**2 * (high - low + 4.0 / 3.0 * radii)
    return starts + low[:, None] * axes, starts + high[:, None] * axes, radii, volumes


def _on_grid(fit: Fitted, pieces: list[ConvexPart]) -> Fitted:
    """Rounded to the grid, the radius upwards until every piece lies inside."""
    a, b = (np.round(end / _GRID_M) * _GRID_M + 0.0 for end in (fit.a, fit.b))
    rounded = Fitted(a, b, 0.0)
    need = max(rounded.excess(piece) for piece in pieces)
    return Fitted(a, b, math.ceil(need / _GRID_M - 1e-7) * _GRID_M)


_STEPS = 33  # points of an edge
_INSIDE = 2000  # points elsewhere


def sticking_out(piece: ConvexPart, capsules: Sequence[Fitted]) -> float:
    """How far a piece reaches out of the union of some capsules [m], at most 0 if it does not.

    Exact where one of them holds it all; else of points on its edges and random ones between.
    """
    least = min((one.excess(piece) for one in capsules), default=np.inf)
    if least <= 0.0 or len(capsules) < 2:
        return least
    points = _points(piece)
    return float(np.min([one.excesses(points, piece.radius) for one in capsules], axis=0).max())


def _points(piece: ConvexPart) -> FloatArray:
    shares = np.linspace(0.0, 1.0, _STEPS)[:, None, None]
    start, end = piece.points[piece.edges[:, 0]], piece.points[piece.edges[:, 1]]
    on_edges = (start + shares * (end - start)).reshape(-1, 3)
    weights = np.random.default_rng(2).exponential(size=(_INSIDE, len(piece.points))) ** 4
    between = weights @ piece.points / weights.sum(axis=1, keepdims=True)
    return np.concatenate([piece.points, on_edges, between])
