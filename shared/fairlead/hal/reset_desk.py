"""``reset_episode``: takes the request on a transport thread, the tick loop carries it out."""

from __future__ import annotations

from threading import Condition

from fairlead.errors import FairleadError, RefusedError
from fairlead.hal.core import HalCore
from fairlead.messages import GateState, ResetEpisode, ResetEpisodeReply, decode

DISARMED_WAIT_S = 0.2
"""How long to wait for a lease that says disarmed, just after an operator disarmed."""
ANSWER_WAIT_S = 60.0
"""How long a simulator may take to reset and to come to standstill."""


class ResetDesk:
    """Hands one request at a time to the tick loop and waits for its answer.

    Args:
        changed: the lock and condition that guard the core; the tick loop notifies it.
    """

    def __init__(self, core: HalCore, changed: Condition, who: str) -> None:
        self._core = core
        self._changed = changed
        self._who = who
        self._request: ResetEpisode | None = None
        self._answer: ResetEpisodeReply | FairleadError | None = None

    def handle(self, payload: bytes) -> ResetEpisodeReply:
        """Answer one query; blocks until the new episode stands still.

        Raises:
            RefusedError: not disarmed, another reset is running, or it did not finish.
            FairleadError: what the backend said.
        """
        request = decode(ResetEpisode, payload)
        with self._changed:
            if self._request is not None:
                raise RefusedError(self._who, "another reset_episode is running")
            if not self._changed.wait_for(self._is_disarmed, DISARMED_WAIT_S):
                raise self._not_disarmed()
            self._request = request
            self._changed.notify_all()
            try:
                self._changed.wait_for(lambda: self._answer is not None, ANSWER_WAIT_S)
                answer = self._answer
            finally:
                self._request = self._answer = None
        if answer is None:
            raise RefusedError(self._who, f"reset_episode did not finish in {ANSWER_WAIT_S:g} s")
        if isinstance(answer, FairleadError):
            raise answer
        return answer

    def due(self) -> ResetEpisode | None:
        """The request to carry out now, if any (call with the lock held)."""
        if self._request is None or self._answer is not None:
            return None
        if not self._is_disarmed():  # armed in between
            self.answer(self._request, self._not_disarmed())
            return None
        return self._request

    def answer(self, request: ResetEpisode, answer: ResetEpisodeReply | FairleadError) -> None:
        """Answer a request that `due` gave out, if its sender still waits."""
        with self._changed:
            if self._request is request:
                self._answer = answer
            self._changed.notify_all()

    def _is_disarmed(self) -> bool:
        return self._core.gate_state == GateState.DISARMED

    def _not_disarmed(self) -> RefusedError:
        state = self._core.gate_state
        if state is None:
            return RefusedError(
                self._who, "no lease received, so the gate may be armed", "fairlead status"
            )
        name = GateState(state).name.lower() if state in set(GateState) else str(state)
        return RefusedError(
            self._who, f"reset_episode needs a disarmed gate, it is {name}", "fairlead disarm"
        )
