"""What the HAL measured at one tick: its joints and its transforms, together."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from fairlead.errors import LayoutError
from fairlead.messages import JointState, Transform, TransformBatch, floats

FrameNames = tuple[str, str]


@dataclass(frozen=True)
class Tick:
    """One tick, whole: rows computed from it cite its ``number``.

    transforms: by parent and child: the HAL's of this tick, and its static ones.
    """

    number: int
    joints: JointState
    transforms: Mapping[FrameNames, Transform]

    def planar_pose(self, parent: str, child: str) -> tuple[float, float, float]:
        """Position x, y [m] and yaw [rad] of frame ``child`` in frame ``parent``.

        Raises:
            LayoutError: the HAL sends no such transform; those that it sends are named.
        """
        found = self.transforms.get((parent, child))
        if found is None:
            valid = ", ".join(f"{one} -> {other}" for one, other in sorted(self.transforms))
            raise LayoutError(
                f"tick {self.number}: no transform {parent} -> {child} (valid: {valid or 'none'})",
                kind="missing_frame",
                name=child,
                parent=parent,
            )
        x_m, y_m, _ = (float(number) for number in floats(found.translation))
        x, y, z, w = (float(number) for number in floats(found.rotation_xyzw))
        return x_m, y_m, math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


class TickBuilder:
    """Puts ticks together from the HAL's messages; transforms of a tick come before its joints."""

    def __init__(self, session: int) -> None:
        self._session = session
        self._static: dict[FrameNames, Transform] = {}
        self._moving: TransformBatch | None = None

    def on_transforms(self, batch: TransformBatch) -> None:
        """Take what the HAL sent; another session's is nobody's."""
        if batch.session != self._session:
            return
        if batch.is_static:
            self._static = _by_name(batch)
        else:
            self._moving = batch

    def on_joints(self, state: JointState) -> Tick | None:
        """The tick that these joints complete; None if its transforms were lost on the way."""
        moving = self._moving
        if state.session != self._session or moving is None or moving.tick != state.tick:
            return None
        return Tick(state.tick, state, self._static | _by_name(moving))


def _by_name(batch: TransformBatch) -> dict[FrameNames, Transform]:
    return {(one.parent, one.child): one for one in batch.transforms}
