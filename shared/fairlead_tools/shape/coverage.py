"""Whether capsules cover a piece."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fairlead.messages import FloatArray
from fairlead_tools.shape.convex_part import ConvexPart
from fairlead_tools.shape.fit import Fitted

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
