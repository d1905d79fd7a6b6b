"""``reset_episode``: takes the request on a transport thread, the tick loop carries it out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from threading import Condition

from fairlead.errors import RefusedError
from fairlead.hal.core import HalCore
from fairlead.messages import GateState, ResetEpisode, ResetEpisodeReply, decode
from fairlead.wire.bus import Answer

DISARMED_WAIT_NS = 200_000_000
"""How long to wait for a lease that says disarmed, just after an operator disarmed."""
ANSWER_WAIT_NS = 55_000_000_000
"""How long a simulator may take to reset and to come to standstill; who asks waits for 60 s."""


@dataclass
class _Pending:
    """A request that is not answered yet."""

    request: ResetEpisode
    answer: Answer
    until_ns: int
    begun: bool = False


class ResetDesk:
    """Hands one request at a time to the tick loop; nobody waits for its answer in a callback.

    Args:
        changed: the lock and condition that guard the core; the tick loop notifies it.
        clock: monotonic nanoseconds.
    """

    def __init__(
        self, core: HalCore, changed: Condition, who: str, clock: Callable[[], int]
    ) -> None:
        self._core = core
        self._changed = changed
        self._who = who
        self._clock = clock
        self._pending: _Pending | None = None
        self._closed = ""

    def handle(self, payload: bytes, answer: Answer) -> None:
        """Take one query; ``answer`` is called once the new episode stands still.

        Raises:
            RefusedError: another reset is running, or none is possible any more.
        """
        request = decode(ResetEpisode, payload)
        with self._changed:
            if self._closed:
                raise RefusedError(self._who, self._closed)
            if self._pending is not None:
                raise RefusedError(self._who, "another reset_episode is running")
            self._pending = _Pending(request, answer, self._clock() + DISARMED_WAIT_NS)
            self._changed.notify_all()

    def due(self) -> ResetEpisode | None:
        """The request to carry out now, if any (call with the lock held)."""
        pending = self._pending
        if pending is None or pending.begun or not self._is_disarmed():
            return None
        pending.begun, pending.until_ns = True, self._clock() + ANSWER_WAIT_NS
        return pending.request

    def refuse_late(self) -> None:
        """Refuse the request that the gate's state, or the simulator, kept waiting for too long."""
        with self._changed:
            pending = self._pending
            if pending is None or self._clock() < pending.until_ns:
                return
            seconds = ANSWER_WAIT_NS / 1e9
            late = RefusedError(self._who, f"reset_episode did not finish in {seconds:g} s")
            reason = late if pending.begun else self._not_disarmed()
            self._pending = None
        pending.answer(reason)

    def answer(self, request: ResetEpisode, outcome: ResetEpisodeReply | Exception) -> None:
        """Answer a request that `due` gave out, if its sender still waits."""
        with self._changed:
            pending = self._pending
            if pending is None or pending.request is not request:
                return
            self._pending = None
        pending.answer(outcome)

    def close(self, reason: str) -> None:
        """Refuse what waits and whatever comes, for this reason."""
        with self._changed:
            self._closed = reason
            pending, self._pending = self._pending, None
        if pending is not None:
            pending.answer(RefusedError(self._who, reason))

    def _is_disarmed(self) -> bool:
        return self._core.gate_state == GateState.DISARMED

    def _not_disarmed(self) -> RefusedError:
        state = self._core.gate_state
        if state is None:
            return RefusedError(
                self._who, "no lease received, so the gate may be armed", "fairlead status"
            )
        name = GateState(state).name.lower() if state in set(GateState) else str(state)
        # A stop or a latch is not disarmed but reset, by an id that the gate's status tells.
        fix = "fairlead disarm" if state == GateState.ARMED else "fairlead status"
        return RefusedError(self._who, f"reset_episode needs a disarmed gate, it is {name}", fix)
