"""The execution guard: decides, tick by tick, what the robot may execute.

A claim's parts execute the row of tick n only if the row is in a SafeChunk that continues
what the claim really did in tick n - 1, the newest lease grants that claim for n, the lease
is fresh (realtime) or is the decided lease of n itself (lockstep), and no stop is held.
Otherwise they hold. Before the first lease every part holds.

Pure: no clock (time is an argument), no I/O, no threads. The caller serialises the calls.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from fairlead.hal.backend import PartCommand
from fairlead.hal.claims import ClaimRows, ClaimTable, ReleasedChunk, decode_released
from fairlead.hal.lease_follower import LEASE_LIFE_NS, SECOND_GATE, LeaseFollower, OneGate, foreign
from fairlead.hal.stop_register import StopRegister
from fairlead.messages import (
    HELD,
    Acted,
    Decision,
    Grant,
    Hold,
    JointState,
    Lease,
    SafeChunk,
    StopLevel,
)


@dataclass(frozen=True)
class TickPlan:
    """One tick, decided: ``acted`` per part; ``commands`` by part index, the rest hold.

    lease_ns: when the newest lease had come, on the HAL's monotonic clock; 0: none had.
    """

    tick: int
    acted: tuple[Acted, ...]
    commands: Mapping[int, PartCommand]
    lease_ns: int


@dataclass(frozen=True)
class Wait:
    """Lockstep: the world stands. ``lease``: a decision is missing; ``standstill``: paused."""

    reason: Literal["lease", "standstill"]


Pacing = Literal["realtime", "lockstep"]
FORGED_CHUNK = "chunk of a second live gate"


class HalCore:
    """Takes SafeChunks, leases and stops in any order; answers one plan per tick.

    The ``on_`` methods return "" if the message was taken, else the reason it was not.

    Args:
        session, limits: as `LeaseFollower` has them.
        part_count: parts of the robot.
        n_dof: commanded joints, the width of joint modes.
        period_ns: the control period.
    """

    def __init__(
        self, session: int, pacing: Pacing, part_count: int, n_dof: int, period_ns: int,
        limits: bytes = b"",
    ) -> None:  # fmt: skip
        self._session = session
        self._pacing = pacing
        self._part_count = part_count
        self._n_dof = n_dof
        self._pause_ns = period_ns + LEASE_LIFE_NS
        self._decided_ns: int | None = None
        self._lease = LeaseFollower(session, limits)
        self._stops = StopRegister()
        self._claims = ClaimTable()
        self._gate = OneGate(session, self._lease, self._claims)
        self._acted: tuple[Acted, ...] = (HELD,) * part_count
        self._tick = 0
        self._resetting = False

    @property
    def acted(self) -> tuple[Acted, ...]:
        """Per part, what it did in the tick decided last."""
        return self._acted

    @property
    def gate_state(self) -> int | None:
        """The gate's state by the newest lease, None before the first."""
        return self._lease.state

    @property
    def leases(self) -> LeaseFollower:
        """Which lease is followed, and since when."""
        return self._lease

    @property
    def held_stops(self) -> tuple[StopLevel, ...]:
        """The stops that hold the robot now."""
        return self._stops.held

    @property
    def demanded_stops(self) -> tuple[tuple[str, str], ...]:
        """Stops to raise now, as cause and details; until `on_stop_raised` all parts hold."""
        return self._stops.demanded

    def stops_to_repeat(self) -> tuple[StopLevel, ...]:
        """Stops to publish again every 50 ms: held here, not yet listed by the gate."""
        return self._stops.to_repeat()

    def on_lease(self, lease: Lease, now_ns: int) -> str:
        """Follow a lease received at ``now_ns`` (own monotonic clock)."""
        followed = self._lease.newest
        refused = self._lease.offer(lease, now_ns)
        if refused == SECOND_GATE:
            self._stops.demand("two gates", foreign(f"lease {lease.lease_seq}", lease, followed))
        if refused:
            return refused
        self._stops.on_lease(lease)
        for claim in self._claims:
            if self._lease.has_left(claim.epoch):
                self._claims.drop(claim)
        return ""

    def on_safe_chunk(self, message: SafeChunk) -> str:
        """Store released rows until their first tick.

        Raises:
            MessageError: if the chunk does not fit the robot's parts, modes or joints.
        """
        if self._gate.cannot_send(message):
            what = f"verdict {message.verdict_id}"
            self._stops.demand("two gates", foreign(what, message, self._lease.newest))
            return FORGED_CHUNK
        if message.session != self._session:
            return "chunk of another session"
        if self._lease.has_left(message.epoch):
            return "chunk of an epoch already left"
        if message.first_tick <= self._tick:
            return "chunk whose first tick has passed"
        chunk = decode_released(message, self._part_count, self._n_dof)
        return self._claims.store(chunk, self._granted())

    def on_stop(self, stop: StopLevel) -> str:
        """Hold a stop, from the bus or raised by this HAL."""
        return self._stops.hold(stop)

    def on_unreadable_stop(self, why: str) -> None:
        """Bytes on the stop key that are no stop: somebody wants one, so everything holds."""
        self._stops.demand("unreadable stop", why)

    def on_state_of_another(self, state: JointState) -> None:
        """A joint state that this HAL did not send: the gate would judge by it."""
        if state.session == self._session:
            detail = f"somebody else sends this session's joint states, tick {state.tick}"
            self._stops.demand("two HALs", detail)

    def on_stop_raised(self, cause: str, stop: StopLevel) -> None:
        """Hold the stop that was demanded for ``cause``."""
        self._stops.raised(cause, stop)

    def set_resetting(self, resetting: bool) -> None:
        """While resetting every part holds and no lease is needed; rows of before it are gone."""
        self._resetting = resetting
        self._claims.drop_rows()

    def void(self, hold: Hold) -> None:
        """The tick decided last was not carried out: every part held instead."""
        self._acted = (_held(hold),) * self._part_count
        self._claims.hold_all(self._tick, _held(hold))

    def decide(self, tick: int, now_ns: int, is_still: bool) -> TickPlan | Wait:
        """Decide ``tick``; a plan is final and must be carried out, `Wait` changes nothing.

        Args:
            tick: higher than any decided before; skipped ticks count as held.
            now_ns: own monotonic clock, for the freshness of the lease (realtime).
            is_still: whether the robot stands still; a paused lockstep world does not step.
        """
        if tick <= self._tick:
            raise ValueError(f"tick {tick} was decided before (newest {self._tick})")
        if tick != self._tick + 1:
            # Hardware skipped a tick in number: what acted in it was the hold law.
            self._acted = (_held(Hold.NO_ROW),) * self._part_count
            self._claims.forget_rows()
        everyone = self._hold_for_everyone(now_ns, self._decided_ns)
        grants = {grant.claim_id: grant for grant in self._lease.grants()}
        if self._pacing == "lockstep" and not self._resetting:
            if self._stops.any_held or not grants:
                if is_still:
                    return Wait("standstill")
            elif not self._all_decided(tick, grants.values()):
                return Wait("lease")
        chosen = {
            claim.claim_id: (None, everyone)
            if everyone
            else self._choose(claim, tick, grants.get(claim.claim_id))
            for claim in self._claims
        }
        self._decided_ns = now_ns
        return self._commit(tick, _without_conflicts(chosen), everyone or Hold.NO_CLAIM)

    def _granted(self) -> frozenset[int]:
        return frozenset(grant.claim_id for grant in self._lease.grants())

    def _hold_for_everyone(self, now_ns: int, before_ns: int | None) -> Hold:
        if self._stops.any_held:
            return Hold.STOPPED
        if self._resetting:
            return Hold.RESETTING
        if self._lease.newest is None:
            return Hold.STARTING
        if self._pacing == "lockstep":
            return Hold.NONE
        # A process that was stopped finds leases that were sent before and only now received: they
        # look fresh. So the tick after a pause holds, which discards the rows and leaves the
        # receiving thread a period to read what came meanwhile, in order.
        if before_ns is not None and now_ns - before_ns > self._pause_ns:
            return Hold.LEASE_STALE
        return Hold.NONE if self._lease.is_fresh(now_ns) else Hold.LEASE_STALE

    def _all_decided(self, tick: int, grants: Iterable[Grant]) -> bool:
        """Lockstep: the newest lease is of ``tick`` itself, and every row it names is here."""
        newest = self._lease.newest
        assert newest is not None, "grants come from a lease"
        return newest.state_tick == tick and all(
            grant.decision == Decision.HOLD
            or (grant.decision == Decision.ROW and self._named(grant, tick) is not None)
            for grant in grants
        )

    def _named(self, grant: Grant, tick: int) -> ReleasedChunk | None:
        claim = self._claims.get(grant.claim_id)
        if claim is None or self._lease.grant(grant.claim_id, claim.epoch, tick) is None:
            return None
        return claim.named(grant.verdict_id, tick, self._acted)

    def _choose(self, claim: ClaimRows, tick: int, grant: Grant | None) -> _Choice:
        """The chunk whose row the claim executes in ``tick``, or why it holds."""
        if grant is None or self._lease.grant(claim.claim_id, claim.epoch, tick) is None:
            return None, Hold.NOT_GRANTED
        if self._pacing == "lockstep":
            chunk = self._named(grant, tick) if grant.decision == Decision.ROW else None
            return chunk, Hold.NONE if chunk else Hold.REFUSED
        chunk = claim.candidate(tick, self._acted)
        if chunk is None:
            return None, Hold.SUPERSEDED if claim.has_due(tick) else Hold.NO_ROW
        return chunk, Hold.NONE

    def _commit(self, tick: int, chosen: dict[int, _Choice], unclaimed: Hold) -> TickPlan:
        acted = [_held(unclaimed)] * self._part_count
        commands: dict[int, PartCommand] = {}
        for claim in self._claims:
            chunk, hold = chosen[claim.claim_id]
            if chunk is None:
                for part in claim.parts - commands.keys():
                    acted[part] = _held(hold)
                claim.commit(tick, None, _held(hold))
                continue
            row = tick - chunk.first_tick
            for part, command in chunk.commands(row).items():
                commands[part] = command
                acted[part] = chunk.acted(row)
            claim.commit(tick, chunk, chunk.acted(row))
        self._tick = tick
        self._acted = tuple(acted)
        self._claims.drop_dead(self._granted())
        return TickPlan(tick, self._acted, commands, self._lease.received_ns)


_Choice = tuple[ReleasedChunk | None, Hold]


def _held(hold: Hold) -> Acted:
    return Acted(hold=hold, verdict_id=0, row=0)


def _without_conflicts(chosen: dict[int, _Choice]) -> dict[int, _Choice]:
    """Claims that would command the same part in one tick all hold.

    The gate never grants one part twice; two chunks that say otherwise cannot both be right.
    """
    users: dict[int, int] = {}
    for chunk, _ in chosen.values():
        for part in chunk.part_indices if chunk else ():
            users[part] = users.get(part, 0) + 1
    return {
        claim_id: (None, Hold.SUPERSEDED)
        if chunk is not None and any(users[part] > 1 for part in chunk.part_indices)
        else (chunk, hold)
        for claim_id, (chunk, hold) in chosen.items()
    }
