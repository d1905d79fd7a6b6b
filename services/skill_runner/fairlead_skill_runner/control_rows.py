"""A policy slower than the robot: each of its rows becomes a row for each control period."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec
import numpy as np

from fairlead.messages import ActionPart, FloatArray, floats, pack_floats
from fairlead.modes import ControlMode
from fairlead.skill.manifest import Between

_TARGETS = frozenset({ControlMode.JOINT_POSITION, ControlMode.DEX_HAND_JOINT})


def control_rows(
    parts: Iterable[ActionPart], widths: Iterable[int], periods: int, between: Between, most: int
) -> tuple[ActionPart, ...]:
    """Parts with ``periods`` rows for each row of the policy, of them the first ``most``.

    Positions and poses are held, or with ``linear`` go evenly from row to row (a pose's turn about
    one axis) and hold at the last. Velocities, grippers and switches are always held. A delta is
    divided: ``periods`` rows of it make the policy's step.

    Args:
        widths: numbers of a row, part by part.
    """
    spread = []
    for part, width in zip(parts, widths, strict=True):
        mode, values = ControlMode(part.mode), floats(part.values, width)
        made = _spread(values, mode, periods, between)[:most] if periods > 1 else values[:most]
        spread.append(msgspec.structs.replace(part, values=pack_floats(made)))
    return tuple(spread)


def _spread(values: FloatArray, mode: ControlMode, periods: int, between: Between) -> FloatArray:
    held: FloatArray = np.repeat(values, periods, axis=0)
    if mode.adds_up:
        return held / periods
    if between == "hold" or mode not in {*_TARGETS, ControlMode.CARTESIAN_POSE}:
        return held
    following = np.repeat(np.vstack([values[1:], values[-1:]]), periods, axis=0)
    share = np.tile(np.arange(periods) / periods, len(values))[:, None]
    if mode in _TARGETS:
        return held + share * (following - held)
    made = held.copy()
    made[:, :3] += share * (following[:, :3] - held[:, :3])
    made[:, 3:] = turned(held[:, 3:], following[:, 3:], share)
    return made


def turned(one: FloatArray, other: FloatArray, share: FloatArray) -> FloatArray:
    """Unit quaternions ``[n, 4]`` at a share ``[n, 1]`` of the way between two, the short one."""
    cosine = np.sum(one * other, axis=1, keepdims=True)
    other, cosine = np.where(cosine < 0.0, -other, other), np.abs(cosine)
    angle = np.arccos(np.clip(cosine, 0.0, 1.0))
    sine = np.sin(angle)
    near = sine < 1e-9  # the same rotation: nothing between
    safe = np.where(near, 1.0, sine)
    mixed = (np.sin((1.0 - share) * angle) * one + np.sin(share * angle) * other) / safe
    return np.where(near | (share == 0.0), one, mixed)
