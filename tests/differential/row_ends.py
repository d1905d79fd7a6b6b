"""Where rows of a chunk end, and what is left to the limits there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio

from fairlead.messages import FloatArray

Margins = dict[int, float]
"""What is left to the limit, by code, negative beyond it."""


@dataclass
class RowMargins:
    """at_ends: at the row and where braking ends. anywhere: there and on the way."""

    at_ends: Margins
    anywhere: Margins


@dataclass
class RowEnd:
    """joints: where a row leads. straight: where its first step of least squares does."""

    joints: FloatArray
    straight: FloatArray


@dataclass
class Spread:
    """Between which positions the joints can be, whatever share of each row has happened."""

    lowest: FloatArray
    highest: FloatArray

    def after(self, before: list[FloatArray], now: list[FloatArray], adds_up: bool) -> Spread:
        """Of a row that leads from ``before`` to ``now``, for either end of the gain."""
        if not adds_up:
            return Spread(np.min(now, axis=0), np.max(now, axis=0))
        changes = np.array(now) - np.array(before)
        return Spread(self.lowest + changes.min(axis=0), self.highest + changes.max(axis=0))


def least(margins: list[Margins]) -> Margins:
    """Of several places the smallest margin, code by code."""
    return {code: min(one[code] for one in margins if code in one) for code in margins[0]}


def poses_along(tool: Any, motions: FloatArray) -> FloatArray:
    """Rows of poses: a tool's (an SE3) after motions along the root's axes, one after another."""
    found = []
    for motion in motions:
        turn = pinocchio.exp3(motion[3:]) @ tool.rotation
        tool = pinocchio.SE3(turn, tool.translation + motion[:3])
        found.append(pinocchio.SE3ToXYZQUAT(tool))
    return np.array(found)
