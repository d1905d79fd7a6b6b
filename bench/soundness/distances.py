"""Distances of segments and of flat convex shapes, many at once, by numpy."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray

TINY = 1e-12


def between_segments(
    start: FloatArray, end: FloatArray, start_too: FloatArray, end_too: FloatArray
) -> FloatArray:
    """Smallest distances of two batches of segments, each ``[..., 3]``.

    The best point of the one for the ends of the other, and where both lines are nearest.
    """
    one, other, gap = end - start, end_too - start_too, start - start_too
    a, e, f = _dot(one, one), _dot(other, other), _dot(other, gap)
    b, c = _dot(one, other), _dot(one, gap)
    denominator = a * e - b * b
    inner = np.divide(
        b * f - c * e, denominator, out=np.zeros_like(a), where=denominator > TINY * (a * e + TINY)
    )
    found = np.full(a.shape, np.inf)
    for share in (np.clip(inner, 0.0, 1.0), np.zeros_like(a), np.ones_like(a)):
        point = start + one * share[..., None]
        found = np.minimum(found, to_segment(point, start_too, end_too))
    for point in (start_too, end_too):
        found = np.minimum(found, to_segment(point, start, end))
    return found


def to_segment(point: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Distance of points to segments, each ``[..., 3]``."""
    way = end - start
    square = _dot(way, way)
    share = np.divide(_dot(point - start, way), square, out=np.zeros_like(square), where=square > 0)
    nearest = start + way * np.clip(share, 0.0, 1.0)[..., None]
    return np.asarray(np.linalg.norm(point - nearest, axis=-1))


def inside_polygon(points: FloatArray, corners: FloatArray) -> FloatArray:
    """How far points ``[..., 2]`` are within a counter-clockwise polygon; outside below 0."""
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([-edges[:, 1], edges[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.min(points @ normals.T - _dot(corners, normals), axis=-1))


def between_polygons(shapes: FloatArray, corners: FloatArray) -> FloatArray:
    """A lower bound of the gap between convex shapes ``[B, k, 2]`` and a polygon; below 0: none."""
    best = np.full(len(shapes), -np.inf)
    for axis in _normals(corners):
        best = np.maximum(best, (shapes @ axis).min(axis=1) - (corners @ axis).max())
        best = np.maximum(best, (corners @ axis).min() - (shapes @ axis).max(axis=1))
    for edge in range(shapes.shape[1]):
        way = shapes[:, (edge + 1) % shapes.shape[1]] - shapes[:, edge]
        axes = np.stack([way[:, 1], -way[:, 0]], axis=1)
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        other = corners @ axes.T
        best = np.maximum(best, other.min(axis=0) - _dot(shapes[:, edge], axes))
    return best


def _normals(corners: FloatArray) -> FloatArray:
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(np.sum(one * other, axis=-1))
