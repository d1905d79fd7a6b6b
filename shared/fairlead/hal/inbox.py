"""From keys to the core: what the gate and operators publish, decoded; the core behind its lock."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable
from threading import Condition
from typing import TypeVar

from fairlead.errors import MessageError
from fairlead.hal.core import HalCore, TickPlan, Wait
from fairlead.hal.lease_follower import OTHER_SESSION
from fairlead.keys import Keys, last_chunk
from fairlead.messages import JointState, Lease, Message, SafeChunk, StopLevel, decode
from fairlead.wire.bus import Bus, Sample, Undeclare

T = TypeVar("T")


class SharedCore:
    """A `HalCore` behind a lock that is taken here and nowhere else.

    The tick thread decides, the transport's threads fill it.

    What is passed in runs under the lock: it is short, waits for nothing, and uses no
    `SharedCore`.
    """

    def __init__(self, core: HalCore) -> None:
        self._core = core
        self._changed = Condition()

    def read(self, question: Callable[[HalCore], T]) -> T:
        """What the core says."""
        with self._changed:
            return question(self._core)

    def change(self, step: Callable[[HalCore], T]) -> T:
        """Tell the core something; who waits in `decide` looks again."""
        with self._changed:
            try:
                return step(self._core)
            finally:
                self._changed.notify_all()

    def decide(self, step: Callable[[HalCore], TickPlan | Wait], wait_s: float) -> TickPlan | Wait:
        """A decision; after `Wait`, once something has changed within ``wait_s``, another."""
        with self._changed:
            decided = step(self._core)
            if isinstance(decided, Wait) and self._changed.wait(wait_s):
                decided = step(self._core)
            return decided


_LOG = logging.getLogger("hal.inbox")
M = TypeVar("M", bound=Message)

EXPECTED = frozenset(
    {
        "chunk already known",
        "chunk superseded",
        "chunk whose first tick has passed",
        "lease not newer",
        OTHER_SESSION,  # of a gate that has not seen this session yet; any other is `SECOND_GATE`
        "stop already held",
        "stop already reset",
    }
)
"""What a lossy, repeating channel brings every day: counted, not worth a line."""

GATE_READS = 65_536
"""Bytes of a frame: a longer stop the gate could neither list nor reset under its id."""


class HalInbox:
    """Subscribes to safe chunks, leases, stops and others' joint states; hands them to the core.

    Runs on the transport's threads. Bad messages are counted, and logged once per kind.

    Args:
        is_own_state: whether a joint state's bytes are what this HAL sent.

    Attributes:
        refused: how many messages were not taken, by reason.
    """

    def __init__(
        self,
        core: SharedCore,
        bus: Bus,
        keys: Keys,
        clock: Callable[[], int],
        is_own_state: Callable[[bytes], bool],
    ) -> None:
        self._core = core
        self._clock = clock
        self._is_own_state = is_own_state
        self.refused: Counter[str] = Counter()
        self._said: set[str] = set()
        self._subscriptions: list[Undeclare] = [
            bus.subscribe(keys.lease, self._on_lease),
            bus.subscribe(keys.every_safe, self._on_safe_chunk),
            bus.subscribe(keys.stop, self._on_stop),
            bus.subscribe(keys.joints, self._on_joints),
        ]

    def close(self) -> None:
        """Take no more messages."""
        for subscription in self._subscriptions:
            subscription.undeclare()

    def _on_lease(self, sample: Sample) -> None:
        now_ns = self._clock()
        lease = self._decode(Lease, sample)
        if lease is not None:
            self._take(sample.key, lambda core: core.on_lease(lease, now_ns))

    def _on_safe_chunk(self, sample: Sample) -> None:
        chunk = self._decode(SafeChunk, sample)
        if chunk is None:
            return
        if chunk.source != last_chunk(sample.key):
            self._refuse(sample.key, "chunk on another source's key", chunk.source)
            return
        self._take(sample.key, lambda core: core.on_safe_chunk(chunk))

    def _on_stop(self, sample: Sample) -> None:
        readable = len(sample.payload) <= GATE_READS
        stop = self._decode(StopLevel, sample) if readable else None
        if stop is not None:
            self._take(sample.key, lambda core: core.on_stop(stop))
            return
        why = f"{len(sample.payload)} bytes"
        self._core.change(lambda core: core.on_unreadable_stop(why))

    def _on_joints(self, sample: Sample) -> None:
        if self._is_own_state(sample.payload):
            return
        state = self._decode(JointState, sample)
        if state is not None:
            self._core.change(lambda core: core.on_state_of_another(state))

    def _take(self, key: str, take: Callable[[HalCore], str]) -> None:
        try:
            refused = self._core.change(take)
        except MessageError as error:
            self._refuse(key, "chunk that does not fit this robot", str(error))
            return
        if refused:
            self._refuse(key, refused)

    def _decode(self, kind: type[M], sample: Sample) -> M | None:
        try:
            return decode(kind, sample.payload)
        except MessageError as error:
            self._refuse(sample.key, f"{kind.__name__} that cannot be read", str(error))
            return None

    def _refuse(self, key: str, reason: str, detail: str = "") -> None:
        self.refused[reason] += 1
        if reason not in EXPECTED and reason not in self._said:
            self._said.add(reason)
            _LOG.warning("%s: ignored: %s%s", key, reason, f": {detail}" if detail else "")
