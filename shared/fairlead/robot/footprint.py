"""A base's outline at one pose against the zones it must keep, as G034 compares them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from fairlead.robot.surroundings import BaseSurroundings, Corner, Zone


def zone_breach(base: BaseSurroundings, x_m: float, y_m: float, yaw_rad: float) -> str:
    """The first zone that the base would breach, in words; "" if it would breach none.

    Args:
        x_m, y_m, yaw_rad: pose of the root link in odom.
    """
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    outline = [(x_m + cos * x - sin * y, y_m + sin * x + cos * y) for x, y in base.footprint_m]
    for zone in base.zones:
        margin_m = _margin_m(zone, outline)
        if margin_m < 0.0:
            where = "outside" if zone.kind == "keep_in" else "inside"
            return f"{-margin_m:.3g} m {where} {zone.kind} zone {zone.name}"
    return ""


def _margin_m(zone: Zone, outline: Sequence[Corner]) -> float:
    """How far the outline is on the right side of a zone; both are convex."""
    if zone.kind == "keep_in":
        return -max(max(_outside_m(side, outline)) for side in _sides(zone.corners_m))
    ways = [min(_outside_m(side, outline)) for side in _sides(zone.corners_m)]
    ways += [min(_outside_m(side, zone.corners_m)) for side in _sides(outline)]
    return max(ways)


def _sides(corners: Sequence[Corner]) -> list[tuple[Corner, Corner]]:
    return [(corner, corners[(i + 1) % len(corners)]) for i, corner in enumerate(corners)]


def _outside_m(side: tuple[Corner, Corner], points: Sequence[Corner]) -> list[float]:
    """How far each point is on the outer side of an edge of a counter-clockwise polygon."""
    (x, y), (to_x, to_y) = side
    length = math.hypot(to_x - x, to_y - y)
    return [((to_y - y) * (px - x) - (to_x - x) * (py - y)) / length for px, py in points]
