"""Measured joint positions and velocities by name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fairlead.errors import LayoutError
from fairlead.messages import FloatArray


class JointPositions:
    """Positions of one tick, and velocities where somebody measured them.

    Args:
        index: place of each joint in ``values``.
        values: shape ``[n]`` [rad or m].
        velocities: shape ``[n]`` [rad/s or m/s].
    """

    def __init__(
        self, index: dict[str, int], values: FloatArray, velocities: FloatArray | None = None
    ) -> None:
        self._index = index
        self._values = values
        self._velocities = velocities

    @classmethod
    def named(
        cls, names: Sequence[str], values: FloatArray, velocities: FloatArray | None = None
    ) -> JointPositions:
        """Positions ``values`` of the joints ``names``, in the same order."""
        return cls({name: index for index, name in enumerate(names)}, values, velocities)

    def position(self, joint: str) -> float:
        """Position of one joint [rad or m].

        Raises:
            LayoutError: ``missing_joint``, naming it and the joints there are.
        """
        return self._values.item(self._place(joint))

    def velocity(self, joint: str) -> float:
        """Velocity of one joint [rad/s or m/s]; as `position`, also where there are none."""
        if self._velocities is None:
            raise LayoutError(
                f"joint state: no velocities, so none of {joint!r}",
                kind="missing_joint",
                name=joint,
            )
        return self._velocities.item(self._place(joint))

    def positions(self, joints: Sequence[str]) -> FloatArray:
        """Positions of several joints in the order asked for; as `position`."""
        return np.array([self.position(joint) for joint in joints])

    def _place(self, joint: str) -> int:
        index = self._index.get(joint)
        if index is None:
            raise LayoutError(
                f"joint state: no joint {joint!r} (valid: {', '.join(self._index)})",
                kind="missing_joint",
                name=joint,
            )
        return index
