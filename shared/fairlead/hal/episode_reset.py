"""``reset_episode``: a task takes the request and waits, the tick thread carries it out."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from threading import Lock

from fairlead.errors import RefusedError
from fairlead.hal.core import HalCore
from fairlead.hal.inbox import SharedCore
from fairlead.messages import GateState, ResetEpisode, ResetEpisodeReply, decode

DISARMED_WAIT_S = 0.2
"""How long to wait for a lease that says disarmed, just after an operator disarmed."""
SEEN_NS = 50_000_000
"""A gate that sends a lease so long after a status of the HAL has read that status."""
SILENT_NS = 1_000_000_000
"""A gate that sends no lease for so long after it may be armed, for all the HAL knows."""
ANSWER_WAIT_S = 55.0
"""How long a simulator may take to reset and to come to standstill; who asks waits for 60 s."""


@dataclass(eq=False)
class _Pending:
    """A request that is not answered yet; its outcome is running once it was given out.

    Attributes:
        finished: what to answer, and when the status said that it is over.
    """

    request: ResetEpisode
    outcome: Future[ResetEpisodeReply] = field(default_factory=Future)
    finished: tuple[ResetEpisodeReply, int] | None = None

    def answer(self, outcome: ResetEpisodeReply | Exception) -> None:
        """Answer it, unless nobody waits any more."""
        with suppress(InvalidStateError):
            if isinstance(outcome, Exception):
                self.outcome.set_exception(outcome)
            else:
                self.outcome.set_result(outcome)


class EpisodeResetHandler:
    """Hands one request at a time to the tick thread.

    Args:
        who: this service, as a refusal names it.
    """

    def __init__(self, core: SharedCore, who: str, answer_wait_s: float = ANSWER_WAIT_S) -> None:
        self._core, self._who, self._answer_wait_s = core, who, answer_wait_s
        self._lock = Lock()
        self._pending: _Pending | None = None
        self._closed = ""

    async def handle(self, payload: bytes) -> ResetEpisodeReply:
        """Take one query; return once the new episode stands still and the gate can be armed.

        Raises:
            RefusedError: another reset is running, the gate may be armed, it takes too long, or
                none is possible any more.
        """
        pending = self._take(decode(ResetEpisode, payload))
        outcome = asyncio.wrap_future(pending.outcome)
        self._core.change(lambda core: None)  # the tick thread looks again
        try:
            await asyncio.wait({outcome}, timeout=DISARMED_WAIT_S)
            refusal = self._core.read(self._not_disarmed)
            if refusal is not None and pending.outcome.cancel():  # now it cannot begin any more
                raise refusal
            async with asyncio.timeout(self._answer_wait_s):
                return await outcome
        except TimeoutError:
            late = f"reset_episode did not finish in {self._answer_wait_s:g} s"
            raise RefusedError(self._who, late) from None
        finally:
            with self._lock:
                self._pending = None

    def due(self, core: HalCore) -> ResetEpisode | None:
        """The request to carry out now, if any; it is begun then (called in `SharedCore`)."""
        with self._lock:
            pending = self._pending
        if pending is None or core.gate_state != GateState.DISARMED:
            return None
        if pending.outcome.running() or pending.outcome.done():
            return None
        return pending.request if pending.outcome.set_running_or_notify_cancel() else None

    def may_begin(self, core: HalCore, announced_ns: int, now_ns: int) -> bool:
        """Whether the gate, which refuses to arm from ``announced_ns`` on, was not armed before.

        Raises:
            RefusedError: it was, or it is silent.
        """
        refusal = self._not_disarmed(core)
        if refusal is not None:
            raise refusal
        if core.leases.received_ns - announced_ns >= SEEN_NS:
            return True
        if now_ns - announced_ns >= SILENT_NS:
            silent = "the gate is silent, so it may be armed"
            raise RefusedError(self._who, silent, "fairlead status")
        return False

    def finish(self, request: ResetEpisode, reply: ResetEpisodeReply, ready_ns: int) -> None:
        """A request that `due` gave out is carried out, as the status says since ``ready_ns``."""
        with self._lock:
            if self._pending is not None and self._pending.request is request:
                self._pending.finished = reply, ready_ns

    def answer_finished(self, now_ns: int) -> None:
        """Answer what is finished once the gate has read that; a silent one is not waited for."""
        with self._lock:
            pending = self._pending
        if pending is not None and pending.finished is not None:
            reply, ready_ns = pending.finished
            read_ns = self._core.read(lambda core: core.leases.received_ns) - SEEN_NS
            if read_ns >= ready_ns or now_ns - ready_ns >= SILENT_NS:
                pending.answer(reply)

    def refuse(self, request: ResetEpisode, why: Exception) -> None:
        """Answer a request that `due` gave out, if its sender still waits."""
        with self._lock:
            pending = self._pending
        if pending is not None and pending.request is request:
            pending.answer(why)

    def close(self, reason: str) -> None:
        """Refuse what waits and whatever comes, for this reason."""
        with self._lock:
            self._closed, pending = reason, self._pending
        if pending is not None:
            pending.answer(RefusedError(self._who, reason))

    def _take(self, request: ResetEpisode) -> _Pending:
        with self._lock:
            if self._closed:
                raise RefusedError(self._who, self._closed)
            if self._pending is not None:
                raise RefusedError(self._who, "another reset_episode is running")
            self._pending = _Pending(request)
            return self._pending

    def _not_disarmed(self, core: HalCore) -> RefusedError | None:
        state = core.gate_state
        if state == GateState.DISARMED:
            return None  # the tick thread, in a long tick, has not looked yet
        if state is None:
            return RefusedError(
                self._who, "no lease received, so the gate may be armed", "fairlead status"
            )
        name = GateState(state).name.lower() if state in set(GateState) else str(state)
        # A stop or a latch is not disarmed but reset, by an id that the gate's status tells.
        fix = "fairlead disarm" if state == GateState.ARMED else "fairlead status"
        return RefusedError(self._who, f"reset_episode needs a disarmed gate, it is {name}", fix)
