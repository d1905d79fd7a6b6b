"""Where every link is at many configurations at once, from the gate file's tree, by numpy."""

from __future__ import annotations

from typing import Any

import numpy as np

from bench.equipment.kinematics import rotation_of
from fairlead.messages import FloatArray


class LinkFrames:
    """file: a gate file. Poses are in the root link.

    Attributes:
        moved: by link, whether any joint is between it and the root.
    """

    def __init__(self, file: dict[str, Any]) -> None:
        tree = file["kinematics"]
        names = [joint["name"] for joint in (*file["joints"], *file["passive_joints"])]
        self.names = [tree["root"], *(link["name"] for link in tree["links"])]
        self._links = [
            (
                self.names.index(link["parent"]),
                None if link["joint"] is None else names.index(link["joint"]),
                link["kind"],
                np.array(link["axis"]),
                np.array(link["translation"]),
                rotation_of(np.array(link["rotation_xyzw"])),
            )
            for link in tree["links"]
        ]
        self.moved = [False]
        for parent, joint, *_ in self._links:
            self.moved.append(joint is not None or self.moved[parent])

    def at(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions ``[links, B, 3]`` and rotations ``[links, B, 3, 3]``. q: ``[B, measured]``."""
        count = len(q)
        places = np.zeros((len(self.names), count, 3))
        turns = np.tile(np.eye(3), (len(self.names), count, 1, 1))
        for index, (parent, joint, kind, axis, shift, turn) in enumerate(self._links, start=1):
            place = places[parent] + turns[parent] @ shift
            own = turns[parent] @ turn
            if joint is not None and kind == "prismatic":
                place = place + (own @ axis) * q[:, joint, None]
            elif joint is not None:
                own = own @ turned(axis, q[:, joint])
            places[index], turns[index] = place, own
        return places, turns


def turned(axis: FloatArray, angles: FloatArray) -> FloatArray:
    """Rotation matrices ``[B, 3, 3]`` about one unit vector."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, less = np.sin(angles)[:, None, None], (1.0 - np.cos(angles))[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + less * (cross @ cross))
