"""Transforms of the last ticks, looked up at one tick.

A pure container: no clock, no transport. Every transform is T_parent_child, measured at
a tick (dynamic) or for good (static). A lookup walks the tree at one tick; each dynamic
transform on the way is the one of that tick, or interpolated between its neighbours (for
frames with a declared maximum age: between two that are no further away), or, for frames
with a declared maximum age, the newest older one.

A frame has one publisher and one parent, and is static or dynamic. A transform that says
otherwise is not taken, and the frame cannot be looked up while somebody sends such ones.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence

from fairlead.messages import TransformBatch
from fairlead_state_assembler import lookup_errors
from fairlead_state_assembler.branches import (
    HISTORY_TICKS,
    Branch,
    Climb,
    Series,
    Way,
    interpolated,
)
from fairlead_state_assembler.lookup_errors import Claim
from fairlead_state_assembler.pose_decoding import SE3, decode_pose
from fairlead_state_assembler.transforms_at_tick import TransformsAtTick


class TransformBuffer:
    """Transforms by child frame, of one session and one episode.

    Attributes:
        ways: those that are known by parent and child; what is not is found by `find_way`.

    Args:
        max_age_ticks: by child frame, how many ticks old its newest transform may be
            when there is none for the tick asked for; 0 for every frame not named.
        owners: by child frame, the only publisher that may send it. Other frames belong to
            whoever sends them first in an episode.
        hal: the publisher whose batches open a new session; anybody else's may be left over
            from a HAL that is gone. "" for any.
    """

    def __init__(
        self,
        max_age_ticks: Mapping[str, int] | None = None,
        owners: Mapping[str, str] | None = None,
        hal: str = "",
    ) -> None:
        self._max_age = dict(max_age_ticks or {})
        self._owners = dict(owners or {})
        self._hal = hal
        self._rivals: dict[str, Claim] = {}  # newest transform of a frame that was not taken
        self._branches: dict[str, Branch] = {}
        # Both of the branches as they are, and known only while nobody contests one.
        self.ways: dict[tuple[str, str], Way] = {}
        self._climbs: dict[tuple[str, str], Climb] = {}
        self._links = Series()
        self._links_hang = False  # each of their frames in that series, as far as it may
        self._session = 0
        self._left_sessions: set[int] = set()
        self._gates_session = 0  # the one that the gate follows, 0 while it says none
        self._episode_tick = 0
        self._newest = 0  # tick of anything taken
        self._published: dict[str, int] = {}  # newest tick of each publisher's batches
        self._static_ahead: dict[str, TransformBatch] = {}  # newest of a session not followed yet

    def follow(self, session: int) -> None:
        """From now on take data of the session that the gate follows, and of no other."""
        self._gates_session = session
        self._left_sessions.discard(session)

    def enter(self, session: int, episode_tick: int) -> bool:
        """Follow a session and episode; everything from before it is discarded.

        Returns:
            False for a session that was already left, or is not the gate's: its data must be
            ignored.
        """
        if session in self._left_sessions or self._gates_session not in (0, session):
            return False
        if session != self._session:
            self._left_sessions.add(self._session)
            self._session, self._episode_tick = session, 0
            self._branches.clear()
            self._forget_ways()
            self._links, self._links_hang = Series(), False
            self._rivals.clear()
            self._published.clear()
            ahead, self._static_ahead = self._static_ahead, {}
            for publisher, batch in ahead.items():
                self.add_batch(batch, publisher)
        if episode_tick > self._episode_tick:
            self._episode_tick = episode_tick
            self._keep(episode_tick, math.inf)
        return True

    def add_batch(self, batch: TransformBatch, publisher: str = "") -> bool:
        """Take one message's transforms; a newer session of the HAL's is followed at once.

        Args:
            publisher: who sent it. A frame that its publisher's newest batch lacks is known
                not to come; without a name it may still be on its way.

        Returns:
            False if it was not taken: before this episode, or another session than the HAL's, of
            which the newest static ones are kept until it is followed.

        Raises:
            MessageError: for a transform that is not 3 + 4 finite numbers with a
                quaternion of length 1; nothing of the batch is taken.
        """
        poses = [
            (item.parent, item.child, decode_pose(item.child, item.translation, item.rotation_xyzw))
            for item in batch.transforms
        ]
        may_open = self._hal in ("", publisher) or batch.session == self._session
        if not may_open or not self.enter(batch.session, 0):
            if batch.is_static and publisher in (self._hal, *self._owners.values()):
                self._static_ahead[publisher] = batch
            return False
        if batch.tick < self._episode_tick:
            return False
        self._newest = max(self._newest, batch.tick)
        for parent, child, pose in poses:
            claim = Claim(publisher, parent, batch.is_static, batch.tick)
            self._take(child, claim, pose)
        if publisher and not batch.is_static:
            self._published[publisher] = max(batch.tick, self._published.get(publisher, 0))
        return True

    def add(self, parent: str, child: str, pose: SE3, tick: int, *, is_static: bool) -> None:
        """Take T_parent_child [m] measured at ``tick``, as of the frame's owner, if it has one."""
        publisher = self._owners.get(child, "")
        self._take(child, Claim(publisher, parent, is_static, tick), pose)

    def add_links(
        self, parent: str, frames: Mapping[str, int], poses: Sequence[SE3], tick: int
    ) -> None:
        """Take T_parent_frame [m] of ``frames`` at ``tick``, as their owner.

        Args:
            frames: each with its place in ``poses``; the same ones every time.
        """
        if not self._links_hang:
            for frame, column in frames.items():
                branch = self._branches.get(frame)
                if branch is None or branch.series is not self._links:
                    claim = Claim(self._owners.get(frame, ""), parent, False, tick)
                    self._hang(frame, claim, self._links, column)
            self._links_hang = not self._rivals
        self._newest = max(self._newest, tick)
        self._links.put(tick, poses)

    def _take(self, child: str, claim: Claim, pose: SE3) -> None:
        branch = self._branches.get(child)
        if branch is None or not self._is_owners(child, claim, branch):
            branch = self._hang(child, claim, Series())
        if branch is None:
            return
        if not claim.is_static:
            branch.series.put(claim.tick, [pose])
        elif not branch.series.ticks or claim.tick >= branch.series.ticks[-1]:
            branch.series.ticks, branch.series.rows = [claim.tick], [[pose]]

    def _hang(self, child: str, claim: Claim, series: Series, column: int = 0) -> Branch | None:
        """A new branch; None, and a rival noted, for a frame that is another's."""
        if child in self._branches or self._owners.get(child, claim.publisher) != claim.publisher:
            self._rivals[child] = claim
            self._forget_ways()
            return None
        branch = Branch(child, claim.parent, claim.is_static, claim.publisher, series, column)
        self._branches[child] = branch
        self._forget_ways()
        return branch

    def _is_owners(self, child: str, claim: Claim, branch: Branch) -> bool:
        """Whether a transform is the frame's, and not one of a second publisher or kind."""
        return (
            self._owners.get(child, claim.publisher) == claim.publisher == branch.publisher
            and claim.parent == branch.parent
            and claim.is_static == branch.is_static
        )

    def at(self, tick: int) -> TransformsAtTick:
        """A view for lookups at one tick, which also remembers the oldest input used."""
        return TransformsAtTick(self, tick)

    def lookup(self, parent: str, child: str, tick: int) -> tuple[SE3, int]:
        """T_parent_child at ``tick`` and the tick of the oldest dynamic transform in it.

        Raises:
            LayoutError: as `TransformsAtTick.pose`.
        """
        view = self.at(tick)
        return view.pose(parent, child), view.oldest_tick

    def find_way(self, parent: str, child: str, tick: int) -> Way:
        """How the frames hang together; raises `LayoutError` as `TransformsAtTick.pose`."""
        above_parent = self._ancestors(parent, child)
        above_child = self._ancestors(child, parent)
        known = set(above_parent)
        common = next((frame for frame in above_child if frame in known), None)
        if common is None:
            self._refuse_contested([*above_child, *above_parent], tick)
            roots = above_parent[-1], above_child[-1]
            owed = [(frame, self._owners[frame]) for frame in roots if frame in self._owners]
            raise lookup_errors.unconnected(parent, child, roots, self.frames, owed)
        paths = [path[: path.index(common)] for path in (above_parent, above_child)]
        for path in paths:
            self._refuse_contested(path, tick)
        way = Way(*map(self._climb, paths))
        if not self._rivals:
            self.ways[parent, child] = way
        return way

    def _climb(self, frames: Sequence[str]) -> Climb | None:
        """By the branches of ``frames``, each of which hangs on the next."""
        climb = None
        for frame in frames:
            key = frames[0], frame
            if key not in self._climbs:
                self._climbs[key] = Climb(climb, self._branches[frame])
            climb = self._climbs[key]
        return climb

    def _ancestors(self, frame: str, other: str) -> list[str]:
        """``frame`` and its parents up to its root."""
        path = [frame]
        while (branch := self._branches.get(path[-1])) is not None:
            if branch.parent in path:
                raise lookup_errors.loop(frame, other, [*path, branch.parent])
            path.append(branch.parent)
        return path

    def _refuse_contested(self, frames: Sequence[str], tick: int) -> None:
        """A rival counts until nothing more came of it for as long as transforms are kept."""
        for frame in frames:
            rival = self._rivals.get(frame)
            if rival is not None and tick - rival.tick <= HISTORY_TICKS:
                branch = self._branches.get(frame)
                known = branch.says() if branch else None
                raise lookup_errors.contested(frame, self._owners.get(frame, ""), known, rival)

    def step(self, branch: Branch, tick: int) -> tuple[SE3, int]:
        """T_parent_frame at ``tick`` and the tick it was measured at; raises `LayoutError`."""
        ticks, frame = branch.series.ticks, branch.child
        if branch.is_static:
            return branch.pose(-1), tick
        index = bisect_left(ticks, tick)
        if index < len(ticks) and ticks[index] == tick:
            return branch.pose(index), tick
        if index == 0:
            raise lookup_errors.not_yet(branch.parent, frame, ticks[0], tick)
        before, allowed = ticks[index - 1], self._max_age.get(frame, 0)
        if index < len(ticks):
            reach = max(1, allowed)
            if tick - before <= reach and ticks[index] - tick <= reach:
                return interpolated(branch, index, tick), before
        if tick - before <= allowed:
            return branch.pose(index - 1), before
        is_newest = index == len(ticks)
        is_dropped = is_newest and self._published.get(branch.publisher, 0) >= tick
        dropped_by = branch.publisher if is_dropped else ""
        raise lookup_errors.stale(branch.says(), frame, before, tick, allowed, dropped_by)

    def _forget_ways(self) -> None:
        self.ways.clear()
        self._climbs.clear()

    @property
    def frames(self) -> frozenset[str]:
        """Every frame some transform names."""
        return frozenset(self._branches) | {b.parent for b in self._branches.values()}

    def discard_after(self, tick: int) -> None:
        """Forget what is of later ticks, the beginning of the episode included."""
        if max(self._newest, self._episode_tick) <= tick:
            return
        self._newest = tick
        self._episode_tick = self._episode_tick if self._episode_tick <= tick else 0
        self._published = {one: at for one, at in self._published.items() if at <= tick}
        self._keep(0, tick)

    def _keep(self, first: int, last: float) -> None:
        self._links_hang = False
        self._rivals = {c: one for c, one in self._rivals.items() if first <= one.tick <= last}
        self._forget_ways()
        for child, branch in list(self._branches.items()):
            branch.series.keep(first, last)
            if not branch.series.ticks:
                del self._branches[child]
                rival = self._rivals.get(child)
                if rival is not None and rival.publisher == branch.publisher:
                    del self._rivals[child]  # its own publisher's way in the new episode
