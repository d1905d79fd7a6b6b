"""Where a base goes, and what is left to its zones, from its rules, not its code."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fairlead.messages import FloatArray


def told_velocities(
    base: dict[str, Any] | None, names: Sequence[str], now: FloatArray, row: FloatArray
) -> FloatArray:
    """Velocities of the joints; a base's slides may be told against its yaw."""
    told = row.copy()
    if base is not None and base["command_frame"] == "against_yaw":
        x, y, yaw = (names.index(name) for name in base["joints"])
        turned = complex(row[x], row[y]) * complex(math.cos(now[yaw]), -math.sin(now[yaw]))
        told[x], told[y] = turned.real, turned.imag
    return told


def base_change(base: dict[str, Any], yaw: float, moved: FloatArray) -> FloatArray:
    """Of x, y [m] and yaw [rad] by a motion along base_link's axes, of its origin."""
    axis = np.array(base["yaw_axis"])
    x, y = moved[:2] + moved[5] * np.array([-axis[1], axis[0]])
    halfway = yaw + 0.5 * moved[5]
    turned = complex(x, y) * complex(math.cos(halfway), math.sin(halfway))
    return np.array([turned.real, turned.imag, moved[5]])


def zone_margin(base: dict[str, Any], pose: FloatArray) -> float:
    """The least room of the footprint in its zones [m]. pose: x, y and yaw of the joints."""
    x, y, yaw = pose
    axis = np.array(base["yaw_axis"])
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    corners = (np.array(base["footprint"]) - axis) @ turn.T + axis + [x, y]
    margin = math.inf
    for zone in base["zones"]:
        edges = np.array(zone["corners"])
        along = np.roll(edges, -1, axis=0) - edges
        inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
        inward /= np.linalg.norm(along, axis=1)[:, None]
        inside = np.einsum("eck,ek->ec", corners[None] - edges[:, None], inward)
        margin = min(margin, float(inside.min()))
    return margin
