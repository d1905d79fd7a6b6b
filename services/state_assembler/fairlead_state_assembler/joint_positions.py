"""Measured joint positions by name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fairlead.errors import LayoutError
from fairlead.messages import FloatArray


class JointPositions:
    """Positions of one tick.

    Args:
        index: place of each joint in ``values``.
        values: shape ``[n]`` [rad or m].
    """

    def __init__(self, index: dict[str, int], values: FloatArray) -> None:
        self._index = index
        self._values = values

    @classmethod
    def named(cls, names: Sequence[str], values: FloatArray) -> JointPositions:
        """Positions ``values`` of the joints ``names``, in the same order."""
        return cls({name: index for index, name in enumerate(names)}, values)

    def position(self, joint: str) -> float:
        """Position of one joint [rad or m].

        Raises:
            LayoutError: ``missing_joint``, naming it and the joints there are.
        """
        index = self._index.get(joint)
        if index is None:
            raise LayoutError(
                f"joint state: no joint {joint!r} (valid: {', '.join(self._index)})",
                kind="missing_joint",
                name=joint,
            )
        return float(self._values[index])

    def positions(self, joints: Sequence[str]) -> FloatArray:
        """Positions of several joints in the order asked for; as `position`."""
        return np.array([self.position(joint) for joint in joints])
