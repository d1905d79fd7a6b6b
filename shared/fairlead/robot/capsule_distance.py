"""Distance between capsules, for many at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fairlead.robot.capsules import Capsule
from fairlead.robot.link_poses import FloatArray, Poses

_TINY = 1e-18  # [m2]: a shorter segment is a point


def capsule_spans(
    capsules: Sequence[Capsule], poses: Mapping[str, Poses]
) -> list[tuple[FloatArray, FloatArray]]:
    """Both ends of each capsule in the root link's frame, ``[n, 3]`` [m]."""
    return [
        (poses[one.link].apply(np.array(one.a_m)), poses[one.link].apply(np.array(one.b_m)))
        for one in capsules
    ]


def pair_distances(
    capsules: Sequence[Capsule],
    spans: Sequence[tuple[FloatArray, FloatArray]],
    first: int,
    second: int,
) -> FloatArray:
    """Distance of two capsules in each pose ``[n]`` [m], negative where they overlap."""
    radii = capsules[first].radius_m + capsules[second].radius_m
    return segment_distance(*spans[first], *spans[second]) - radii


def segment_distance(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Distance between the segments a-b and c-d.

    Less the radii it is that of capsules, negative where they overlap. The nearest points are
    an end and its foot on the other segment, or, of lines that cross, the feet of both lines.

    Args:
        a, b, c, d: points ``[n, 3]`` [m].

    Returns:
        Shape ``[n]`` [m].
    """
    first, second, between = b - a, d - c, c - a
    aa, cc, ac = _dot(first, first), _dot(second, second), _dot(first, second)
    across = aa * cc - ac**2
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (_dot(first, between) * cc - _dot(second, between) * ac) / across
        t = (_dot(first, between) * ac - _dot(second, between) * aa) / across
    inside = (across > _TINY * np.maximum(aa, cc)) & (s > 0) & (s < 1) & (t > 0) & (t < 1)
    s, t = np.where(inside, s, 0.0), np.where(inside, t, 0.0)
    crossing = np.linalg.norm(a + s[:, None] * first - c - t[:, None] * second, axis=1)
    ends = [_to_segment(a, c, second), _to_segment(b, c, second),
            _to_segment(c, a, first), _to_segment(d, a, first)]  # fmt: skip
    return np.asarray(np.minimum(crossing, np.min(ends, axis=0)))


def _to_segment(point: FloatArray, start: FloatArray, along: FloatArray) -> FloatArray:
    """Distance of points from segments ``start + [0, 1] along``."""
    rays = point - start
    share = np.clip(_dot(rays, along) / np.maximum(_dot(along, along), _TINY), 0.0, 1.0)
    return np.asarray(np.linalg.norm(rays - share[:, None] * along, axis=1))


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("ni,ni->n", first, second))
