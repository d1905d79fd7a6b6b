"""Where frames are to each other at one tick."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import pinocchio as pin

from fairlead_state_assembler.branches import Branch, Climb, Way
from fairlead_state_assembler.pose_decoding import SE3


class _Buffer(Protocol):
    """What it is a view of: a `TransformBuffer`."""

    @property
    def ways(self) -> Mapping[tuple[str, str], Way]: ...

    def find_way(self, parent: str, child: str, tick: int) -> Way: ...

    def step(self, branch: Branch, tick: int) -> tuple[SE3, int]: ...


class TransformsAtTick:
    """Lookups at one tick; what several have in common is computed once.

    Of the buffer as it is: whatever comes afterwards needs a new view.

    Attributes:
        oldest_tick: the oldest dynamic transform any lookup of this view used.
    """

    def __init__(self, buffer: _Buffer, tick: int) -> None:
        self._buffer = buffer
        self._tick = tick
        self._ways = buffer.ways
        self._known: dict[Climb, SE3] = {}
        self.oldest_tick = tick

    def pose(self, parent: str, child: str) -> SE3:
        """T_parent_child as a `pinocchio.SE3` [m].

        Raises:
            LayoutError: ``missing_frame`` (unknown or not connected), ``stale_frame``
                (too old), ``missing_tick`` (only newer ones known), ``loop`` or
                ``contested_frame`` (sent by two, or in two ways).
        """
        way = self._ways.get((parent, child))
        if way is None:
            way = self._buffer.find_way(parent, child, self._tick)
        from_parent, from_child = way
        T_common_child = self._climbed(from_child) if from_child else pin.SE3.Identity()
        if from_parent is None:
            return T_common_child
        return self._climbed(from_parent).actInv(T_common_child)

    def _climbed(self, climb: Climb) -> SE3:
        """T_above_frame."""
        pose = self._known.get(climb)
        if pose is None:
            below = climb.below and self._climbed(climb.below)
            branch, series = climb.branch, climb.branch.series
            if series.ticks[-1] == self._tick:  # as most often
                step = series.rows[-1][branch.column]
            else:
                step, used = self._buffer.step(branch, self._tick)
                self.oldest_tick = min(self.oldest_tick, used)
            pose = self._known[climb] = step if below is None else step.act(below)
        return pose
