"""How frames hang on each other: the poses of the last ticks, and who sends them."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import pinocchio as pin

from fairlead_state_assembler.lookup_errors import Claim
from fairlead_state_assembler.pose_decoding import SE3

HISTORY_TICKS = 64  # transforms kept per frame: 3.2 s at 20 Hz, beyond any declared age


@dataclass
class Series:
    """Poses of frames that come together: of each tick a row, in which each has its column."""

    ticks: list[int] = field(default_factory=list)
    rows: list[Sequence[SE3]] = field(default_factory=list)

    def put(self, tick: int, row: Sequence[SE3]) -> None:
        """Take the row of a tick, instead of what it had."""
        index = bisect_left(self.ticks, tick)
        if index < len(self.ticks) and self.ticks[index] == tick:
            self.rows[index] = row
            return
        self.ticks.insert(index, tick)
        self.rows.insert(index, row)
        if len(self.ticks) > HISTORY_TICKS:
            del self.ticks[0], self.rows[0]

    def keep(self, first: float, last: float) -> None:
        """Forget the rows of other ticks."""
        begin, end = bisect_left(self.ticks, first), bisect_right(self.ticks, last)
        self.ticks[:], self.rows[:] = self.ticks[begin:end], self.rows[begin:end]


@dataclass
class Branch:
    """How one frame hangs on its parent; of a static one the series has one row."""

    child: str
    parent: str
    is_static: bool
    publisher: str  # "" where it came in no batch
    series: Series
    column: int = 0

    def pose(self, index: int) -> SE3:
        """T_parent_child of a row."""
        return self.series.rows[index][self.column]

    def says(self) -> Claim:
        """What its publisher says of the frame, without the numbers."""
        return Claim(self.publisher, self.parent, self.is_static, self.series.ticks[-1])


@dataclass(eq=False)  # one of a kind, so a key
class Climb:
    """From a frame up to one above it: by one more branch than the climb below.

    Two ways that begin at a frame share what they have in common.
    """

    below: Climb | None
    branch: Branch


class Way(NamedTuple):
    """From two frames up to the one above both; None for a frame that is that one."""

    from_parent: Climb | None
    from_child: Climb | None


def interpolated(branch: Branch, index: int, tick: int) -> SE3:
    """Linear in position, spherical in rotation, between entries index - 1 and index."""
    before, after = branch.series.ticks[index - 1], branch.series.ticks[index]
    share = (tick - before) / (after - before)
    start, end = branch.pose(index - 1), branch.pose(index)
    rotation = pin.Quaternion(start.rotation).slerp(share, pin.Quaternion(end.rotation))
    translation = (1.0 - share) * start.translation + share * end.translation
    return pin.SE3(rotation.toRotationMatrix(), translation)
