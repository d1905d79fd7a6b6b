"""The gate from when a goal is accepted until it has its claim: after a stop nothing begins."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from fairlead.keys import Keys
from fairlead.messages import ClaimReply, GateState, GateStatus, GoalResult, Lease
from fairlead.wire.bus import Bus
from fairlead.wire.verdict_text import why_not_armed
from fairlead_skill_runner import results
from fairlead_skill_runner.claims import gate_status


class BeforeClaim:
    """A goal takes its claim only if the gate has stayed as it was when the goal came.

    Each arming begins another epoch, and only an armed gate grants claims: one of the same epoch
    says that there was no stop, latch or disarm. Leases say so earlier. They can be late, so
    what they say is asked of the gate itself.

    Args:
        gate: its answer when the goal came; None: none, and no claim is taken.
        end: called on the loop, with how the goal ends.
    """

    def __init__(
        self,
        bus: Bus,
        keys: Keys,
        tasks: asyncio.TaskGroup,
        gate: GateStatus | None,
        end: Callable[[GoalResult], None],
    ) -> None:
        self._bus, self._keys, self._tasks = bus, keys, tasks
        self._gate, self._end = gate, end
        self._asking = self._is_over = False

    def on_lease(self, lease: Lease) -> None:
        """Ask the gate if the lease is another one's than it was."""
        if self._has_left(lease) and not (self._asking or self._is_over):
            self._asking = True
            self._tasks.create_task(self._ask(), name="gate of a goal without a claim")

    def over(self) -> None:
        """The goal has its claim, or has ended: ask no more."""
        self._is_over = True

    def refusal(self, claim: ClaimReply) -> GoalResult | None:
        """How the goal ends, if it must not use this claim."""
        same = self._gate is not None and claim.epoch == self._gate.epoch
        return None if same else results.gate_left(self._what())

    async def _ask(self) -> None:
        now = await gate_status(self._bus, self._keys)
        self._asking = False  # without an answer the next lease asks again
        if now is not None and self._has_left(now) and not self._is_over:
            self._end(results.gate_left(self._what(), why_not_armed(now)))

    def _has_left(self, now: Lease | GateStatus) -> bool:
        if self._gate is None or now.epoch != self._gate.epoch:
            return True
        return self._gate.state == GateState.ARMED and now.state != GateState.ARMED

    def _what(self) -> str:
        if self._gate is None:
            return "the gate did not answer when the goal came"
        if self._gate.state == GateState.ARMED:
            return "the gate has not stayed armed since the goal came"
        return "the gate was not armed when the goal came"
