"""Where a robot may be, by the gate's file and none of the gate's code."""

from __future__ import annotations

from typing import Any

import numpy as np

from bench.soundness.distances import between_polygons, between_segments, inside_polygon
from bench.soundness.link_frames import LinkFrames
from fairlead.messages import FloatArray

EXACT_M = 0.05
"""Capsules further apart than this are told to be so at least."""

RULES = ("bounds", "workspace", "self-collision", "zones")
SPEED = "joint speed"
SPEED_TOLERANCE = 0.01
"""A servo that is told exactly its joint's limit is measured at it, give or take this share."""


class Arena:
    """How much room is left, rule by rule; below 0 is a breach.

    Args:
        file: the gate's.
        margin_m: by which its volumes are smaller than the declared ones.

    Attributes:
        clearance: what the gate keeps between two capsules [m].
        base: indices of the base's x, y and yaw; empty for a robot without.
    """

    def __init__(self, file: dict[str, Any], margin_m: float = 0.0) -> None:
        self._margin = margin_m
        self._links = LinkFrames(file)
        names = [joint["name"] for joint in file["joints"]]
        bounds = [joint.get("bounds") for joint in file["joints"]]
        self.lower = np.array([b["lower"] if b else -np.inf for b in bounds])
        self.upper = np.array([b["upper"] if b else np.inf for b in bounds])
        tools = {part["tool_frame"] for part in file["parts"]} - {None}
        self._tools = [self._links.names.index(tool) for tool in sorted(tools)]
        self._volumes = file["workspace"]["volumes"]
        collision = file["collision"]
        self.clearance = float(collision["clearance"])
        self._capsules = collision["capsules"]
        self._pairs = np.array(collision["pairs"], dtype=int).reshape(-1, 2)
        self._base = file["base"]
        self.base = [names.index(joint) for joint in self._base["joints"]] if self._base else []

    def room(self, q: FloatArray) -> dict[str, FloatArray]:
        """Per rule ``[B]`` [rad or m]. q: ``[B, measured]``. self-collision: from touching."""
        own = q[:, : len(self.lower)]
        places, turns = self._links.at(q)
        return {
            "bounds": np.minimum(own - self.lower, self.upper - own).min(axis=1),
            "workspace": self._workspace(places, turns) + self._margin,
            "self-collision": self._between_capsules(places, turns).min(axis=0, initial=np.inf),
            "zones": self._zones(q),
        }

    def room_of_pairs(self, q: FloatArray) -> FloatArray:
        """Between the capsules of each pair ``[pairs, B]`` [m], from touching."""
        return self._between_capsules(*self._links.at(q))

    def _workspace(self, places: FloatArray, turns: FloatArray) -> FloatArray:
        found = np.full(places.shape[1], np.inf)
        tools = places[self._tools]
        starts, ends, radii = self._ends(places, turns)
        moved = [self._links.moved[self._links.names.index(c["link"])] for c in self._capsules]
        for volume in self._volumes:
            lower, upper = np.array(volume["lower"]), np.array(volume["upper"])
            if volume["kind"] == "keep_in":
                room = np.minimum(tools - lower, upper - tools).min(axis=-1)
            else:
                room = np.concatenate([_gap(tools, tools, lower, upper)])
                near = _gap(starts[moved], ends[moved], lower, upper) - radii[moved, None]
                found = np.minimum(found, near.min(axis=0, initial=np.inf))
            found = np.minimum(found, room.min(axis=0, initial=np.inf))
        return found

    def _ends(
        self, places: FloatArray, turns: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        links = [self._links.names.index(one["link"]) for one in self._capsules]
        a, b = (np.array([one[end] for one in self._capsules]) for end in "ab")
        starts = places[links] + np.einsum("cbij,cj->cbi", turns[links], a)
        ends = places[links] + np.einsum("cbij,cj->cbi", turns[links], b)
        return starts, ends, np.array([one["radius"] for one in self._capsules])

    def _between_capsules(self, places: FloatArray, turns: FloatArray) -> FloatArray:
        starts, ends, radii = self._ends(places, turns)
        one, other = self._pairs.T
        middles, halves = (starts + ends) / 2.0, np.linalg.norm(ends - starts, axis=-1) / 2.0
        thick = (radii[one] + radii[other])[:, None]
        # Balls around the capsules are no further apart than these; nearer ones are looked at.
        found = np.linalg.norm(middles[one] - middles[other], axis=-1)
        found -= halves[one] + halves[other] + thick
        pair, at = np.nonzero(found < EXACT_M)
        a, b = one[pair], other[pair]
        exact = between_segments(starts[a, at], ends[a, at], starts[b, at], ends[b, at])
        found[pair, at] = exact - thick[pair, 0]
        return np.asarray(found)

    def _zones(self, q: FloatArray) -> FloatArray:
        found = np.full(len(q), np.inf)
        if not self._base:
            return found
        shapes = self.footprint(q)
        for zone in self._base["zones"]:
            corners = np.array(zone["corners"])
            if zone["kind"] == "keep_in":
                room = inside_polygon(shapes, corners).min(axis=1)
            else:
                room = between_polygons(shapes, corners)
            found = np.minimum(found, room)
        return found

    def footprint(self, q: FloatArray) -> FloatArray:
        """Corners ``[B, k, 2]`` of the base in odom [m]."""
        axis = np.array(self._base["yaw_axis"])
        x, y, yaw = (q[:, joint] for joint in self.base)
        arms = np.array(self._base["footprint"]) - axis
        cos, sin = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        along = cos * arms[:, 0] - sin * arms[:, 1] + (x + axis[0])[:, None]
        across = sin * arms[:, 0] + cos * arms[:, 1] + (y + axis[1])[:, None]
        return np.stack([along, across], axis=-1)


def _gap(start: FloatArray, end: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Distance of segments to a box by points along them; below 0 within it."""
    found = np.full(start.shape[:-1], np.inf)
    for share in np.linspace(0.0, 1.0, 9):
        point = start + (end - start) * share
        beyond = np.maximum(lower - point, point - upper)
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
        found = np.minimum(found, np.where(beyond.max(axis=-1) > 0, outside, beyond.max(axis=-1)))
    return found
