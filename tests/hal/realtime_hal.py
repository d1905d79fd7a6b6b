"""A HAL core in realtime pacing, in virtual time, with a gate that grants."""

from __future__ import annotations

from fairlead.hal.core import HalCore, TickPlan
from fairlead.messages import Acted
from tests.hal.gate_messages import MS, N_DOF, PARTS, PERIOD_NS, SESSION, grant, lease


class RealtimeHal:
    """A core whose leases arrive at each tick, unless a test says otherwise."""

    def __init__(self) -> None:
        self.core = HalCore(SESSION, "realtime", PARTS, N_DOF, PERIOD_NS)
        self.tick = 0
        self.lease_seq = 0

    def grant(self, until_tick: int = 1000, at_ms: int | None = None) -> None:
        self.lease_seq += 1
        now_ns = (self.tick + 1) * 50 * MS if at_ms is None else at_ms * MS
        message = lease(self.lease_seq, self.tick, [grant(until_tick)])
        assert self.core.on_lease(message, now_ns) == ""

    def step(self, at_ms: int | None = None) -> tuple[Acted, ...]:
        self.tick += 1
        now_ns = self.tick * 50 * MS if at_ms is None else at_ms * MS
        plan = self.core.decide(self.tick, now_ns, is_still=True)
        assert isinstance(plan, TickPlan)
        assert set(plan.commands) == {p for p, acted in enumerate(plan.acted) if not acted.hold}
        for command in plan.commands.values():
            assert command.values[0] == self.tick / 1000, "a row of another tick ran"
        return plan.acted

    def holds(self) -> tuple[int, ...]:
        return tuple(acted.hold for acted in self.step())
