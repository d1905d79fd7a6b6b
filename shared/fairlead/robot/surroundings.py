"""Where a robot may be: ``self_collision``, ``workspace`` and ``base`` of ``safety.<profile>``.

Lengths are in metres. Boxes lie along the axes of the description's root link, polygons in
``odom``; a polygon is convex and goes counter-clockwise.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Annotated, Literal, TypeVar

from pydantic import Field, field_validator, model_validator

from fairlead.errors import expected
from fairlead.robot.mode_limits import Finite, Point, Positive, SafetyBlock

Corner = tuple[Finite, Finite]
Kind = Literal["keep_in", "keep_out"]
Place = TypeVar("Place", "Volume", "Zone")
MAX_VOLUMES = 8
MAX_ZONES = 8
MAX_CORNERS = 8


class SelfCollision(SafetyBlock):
    """clearance_m: the least distance between two capsules that are kept apart.

    Choose more than the errors of encoders and capsules.
    """

    clearance_m: Annotated[Positive, Field(le=1.0)]
    source: str


class Volume(SafetyBlock):
    """A box; ``keep_in`` is for tools only, ``keep_out`` for tools and capsules."""

    name: str = Field(min_length=1)
    kind: Kind
    lower_m: Point
    upper_m: Point

    @model_validator(mode="after")
    def _ordered(self) -> Volume:
        for axis, lower, upper in zip("xyz", self.lower_m, self.upper_m, strict=True):
            if lower >= upper:
                raise ValueError(
                    f"volume {self.name!r}: inverted limits along {axis}, lower_m {lower} is not "
                    f"below upper_m {upper}"
                )
        return self


class Workspace(SafetyBlock):
    """Where tools and links may be.

    margin_m: how far a tool ends at most beyond where the gate predicts it, measured. The gate
        keeps this far from the edges of all volumes; 0 keeps tools within them as declared.
    """

    volumes: tuple[Volume, ...] = Field(max_length=MAX_VOLUMES)
    margin_m: Annotated[float, Field(ge=0.0, le=0.1)]
    source: str

    @model_validator(mode="after")
    def _has_room(self) -> Workspace:
        for one in self.volumes:
            sides = [upper - lower for lower, upper in zip(one.lower_m, one.upper_m, strict=True)]
            if one.kind == "keep_in" and min(sides) <= 2.0 * self.margin_m:
                raise ValueError(
                    f"volume {one.name!r}: its least side of {min(sides):g} m is not above twice "
                    f"margin_m {self.margin_m:g}"
                )
        return self

    @field_validator("volumes")
    @classmethod
    def _names_once(cls, volumes: tuple[Volume, ...]) -> tuple[Volume, ...]:
        return _once("volume", volumes)


class Zone(SafetyBlock):
    """A polygon in ``odom`` that the base's footprint stays in, or out of."""

    name: str = Field(min_length=1)
    kind: Kind
    corners_m: tuple[Corner, ...] = Field(min_length=3, max_length=MAX_CORNERS)

    @field_validator("corners_m")
    @classmethod
    def _convex(cls, corners: tuple[Corner, ...]) -> tuple[Corner, ...]:
        return _convex("corners_m", corners)


class BaseSurroundings(SafetyBlock):
    """What G034 judges a mobile base by.

    footprint_m: the base's outline about the root link's origin.
    command_frame: what x and y of ``joint_velocity`` drive. ``odom``: the two slides as told;
        ``against_yaw``: the slides get the told vector turned by minus the measured yaw.
    yaw_axis_m: where the base turns, in the root link's frame.
    reaction_s: time before braking begins.
    tool_drift_m: how far a carried tool goes from where it is predicted while the base drives at
        full speed and until all rests; less in proportion where it is slower.
    clearance_drift_m: how much nearer two capsules come by that.
    """

    footprint_m: tuple[Corner, ...] = Field(min_length=3, max_length=MAX_CORNERS)
    command_frame: Literal["odom", "against_yaw"]
    yaw_axis_m: Corner
    reaction_s: Annotated[Positive, Field(le=10.0)]
    tool_drift_m: Annotated[float, Field(ge=0.0, le=10.0)]
    clearance_drift_m: Annotated[float, Field(ge=0.0, le=1.0)]
    zones: tuple[Zone, ...] = Field(max_length=MAX_ZONES)
    source: str

    @field_validator("footprint_m")
    @classmethod
    def _convex(cls, corners: tuple[Corner, ...]) -> tuple[Corner, ...]:
        return _convex("footprint_m", corners)

    @field_validator("zones")
    @classmethod
    def _usable(cls, zones: tuple[Zone, ...]) -> tuple[Zone, ...]:
        kinds = [zone.kind for zone in zones]
        if "keep_in" not in kinds:
            raise ValueError(expected("zones", "one of kind keep_in", str(kinds)))
        return _once("zone", zones)


def _once(what: str, places: tuple[Place, ...]) -> tuple[Place, ...]:
    for name, count in Counter(place.name for place in places).items():
        if count > 1:
            raise ValueError(f"{what} {name!r} is declared {count} times")
    return places


def _convex(key: str, corners: tuple[Corner, ...]) -> tuple[Corner, ...]:
    count = len(corners)
    sides = ((corners[i], corners[(i + 1) % count]) for i in range(count))
    if all(_left_of(side, _others(corners, side)) for side in sides):
        return corners
    raise ValueError(expected(key, "a convex polygon, counter-clockwise", str(corners)))


def _others(corners: Iterable[Corner], side: tuple[Corner, Corner]) -> list[Corner]:
    """All corners but the side's two, and those again where they are repeated."""
    rest = list(corners)
    for end in side:
        rest.remove(end)
    return rest


def _left_of(side: tuple[Corner, Corner], corners: Iterable[Corner]) -> bool:
    (ax, ay), (bx, by) = side
    return all((bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0 for x, y in corners)


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
