"""Which gate the HAL believes: its newest lease of an epoch not left, and rows only it can send."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from fairlead.hal.claims import ClaimTable
from fairlead.messages import GateState, Grant, Lease, SafeChunk

LEASE_LIFE_NS = 75_000_000
"""Realtime: a lease received longer ago than this grants nothing (three lost in a row)."""

LATE_LEASE_NS = 250_000_000
"""A new lease of an epoch left longer ago than this was not late: its gate is still alive."""

FOLLOWED_LEASES = 256
"""At most so many of an epoch are remembered, to compare others of the same number with."""

OTHER_SESSION = "lease of another session"
OTHER_LIMITS = "the gate has other limits than this HAL; fairlead restart safety, then hal"
SECOND_GATE = "lease of a second live gate"


@dataclass(frozen=True)
class _LeftEpoch:
    lease_seq: int  # the newest one that was followed
    at_ns: int
    tick: int  # of the lease that ended it


class LeaseFollower:
    """Follows a higher ``lease_seq`` of the current epoch, or an epoch never followed before.

    An epoch once left is never followed again. A lease of a new epoch that knows less of
    this robot than the newest one is a late copy of a skipped epoch, and is ignored too.

    What one gate never does tells that a second one, or a forger, is alive (`SECOND_GATE`): it
    says two things under one number; with a number or epoch that it has passed it knows a later
    tick; it goes on long after in an epoch that it left; it turns from this session to another.
    Within an epoch such a lease is followed all the same: a stop holds everything, and if it was
    the gate that was overtaken, it can list that stop.

    Args:
        session: the HAL's own session; leases for any other are ignored.
        limits: hash of the gate file of the HAL's own limits; leases of a gate with others are
            ignored. b"": nobody knows.
    """

    def __init__(self, session: int, limits: bytes = b"") -> None:
        self._session, self._limits = session, limits
        self.has_other_limits = False  # the gate that was heard last
        self._newest: Lease | None = None
        self._received_ns = 0
        self._left_epochs: dict[int, _LeftEpoch] = {}
        self._followed: deque[Lease] = deque(maxlen=FOLLOWED_LEASES)  # newest last

    @property
    def newest(self) -> Lease | None:
        """The lease that is followed, None before the first."""
        return self._newest

    @property
    def epoch(self) -> int:
        """The epoch followed now, 0 before the first lease."""
        return self._newest.epoch if self._newest else 0

    @property
    def state(self) -> int | None:
        """The gate's state as the newest lease says it, None before the first lease."""
        return self._newest.state if self._newest else None

    @property
    def received_ns(self) -> int:
        """When the newest lease came, on the HAL's monotonic clock; 0 before the first."""
        return self._received_ns

    def has_left(self, epoch: int) -> bool:
        """Whether this epoch was followed once and is over."""
        return epoch in self._left_epochs

    def ended_before(self, epoch: int, tick: int) -> bool:
        """Whether an epoch is over whose gate cannot have known this tick."""
        left = self._left_epochs.get(epoch)
        return left is not None and tick > left.tick

    def offer(self, lease: Lease, now_ns: int) -> str:
        """Take a lease. Returns "" if it is now the newest, else why it is not."""
        newest = self._newest
        if lease.session != self._session:
            # 0: of a gate that has just started.
            return SECOND_GATE if newest is not None and lease.session else OTHER_SESSION
        if self._limits and lease.config_hash != self._limits:
            alive = newest is not None and now_ns - self._received_ns <= LATE_LEASE_NS
            self.has_other_limits = not alive
            return SECOND_GATE if alive else OTHER_LIMITS
        left = self._left_epochs.get(lease.epoch)
        if left is not None:
            is_late = now_ns - left.at_ns <= LATE_LEASE_NS and lease.state_tick <= left.tick
            is_new = lease.lease_seq > left.lease_seq and not is_late
            return SECOND_GATE if is_new else "lease of an epoch already left"
        if newest is not None and lease.epoch == newest.epoch:
            if lease.lease_seq <= newest.lease_seq:
                if self._may_be_late(lease):
                    return "lease not newer"
                self._followed.clear()
                self._follow(lease, now_ns)
                return SECOND_GATE
        elif newest is not None:
            if lease.state_tick < newest.state_tick:
                return "lease of a skipped epoch"
            left = _LeftEpoch(newest.lease_seq, now_ns, lease.state_tick)
            self._left_epochs[newest.epoch] = left
            self._followed.clear()
        self._follow(lease, now_ns)
        return ""

    def _follow(self, lease: Lease, now_ns: int) -> None:
        self._newest, self.has_other_limits = lease, False
        self._received_ns = now_ns
        self._followed.append(lease)

    def _may_be_late(self, lease: Lease) -> bool:
        """Whether the gate that is followed can have sent a lease with a number it has passed."""
        followed = next(one for one in self._followed if one.lease_seq >= lease.lease_seq)
        if followed.lease_seq == lease.lease_seq:
            return followed == lease
        return lease.state_tick <= followed.state_tick

    def is_fresh(self, now_ns: int) -> bool:
        """Realtime: whether the newest lease was received within its life."""
        return self._newest is not None and now_ns - self._received_ns <= LEASE_LIFE_NS

    def grants(self) -> tuple[Grant, ...]:
        """Live claims of the newest lease; none unless it says armed."""
        if self._newest is None or self._newest.state != GateState.ARMED:
            return ()
        return self._newest.grants

    def grant(self, claim_id: int, epoch: int, tick: int) -> Grant | None:
        """The grant under which a claim of ``epoch`` may run at ``tick``, if there is one."""
        if epoch != self.epoch:
            return None
        for grant in self.grants():
            if grant.claim_id == claim_id and grant.until_tick >= tick:
                return grant
        return None


class OneGate:
    """Compares released rows with the leases, the claims and the rows that came before.

    One gate says one thing under one verdict's number; with the number rises the tick that it
    judges by. A claim is of one epoch. In an epoch that is over it knows no later tick.

    Args:
        session: the HAL's own.
    """

    def __init__(self, session: int, leases: LeaseFollower, claims: ClaimTable) -> None:
        self._session, self._leases, self._claims = session, leases, claims
        self._newest: SafeChunk | None = None  # of the highest verdict in its epoch

    def cannot_send(self, chunk: SafeChunk) -> bool:
        """Whether no gate that sent what was taken before can have sent this one, be it late."""
        if self._leases.newest is None:
            return False
        claim = self._claims.get(chunk.claim_id)
        return (
            chunk.session != self._session
            or (claim is not None and claim.epoch != chunk.epoch)
            or self._leases.ended_before(chunk.epoch, chunk.judged_tick)
            or (chunk.epoch == self._leases.epoch and self._is_out_of_order(chunk))
        )

    def _is_out_of_order(self, chunk: SafeChunk) -> bool:
        newest = self._newest
        if newest is None or newest.epoch != chunk.epoch:
            self._newest = chunk
            return False
        if chunk.verdict_id == newest.verdict_id:
            return chunk != newest
        is_later = chunk.verdict_id > newest.verdict_id
        earlier, self._newest = (newest, chunk) if is_later else (chunk, newest)
        return earlier.judged_tick > self._newest.judged_tick


def foreign(what: str, sent: Lease | SafeChunk, followed: Lease | None) -> str:
    """What was sent, and by whom it was not."""
    assert followed is not None, "only beside a gate that is followed is there a second one"
    return (
        f"{what} of epoch {sent.epoch:016x}, session {sent.session:016x}, is not of the gate that "
        f"sent lease {followed.lease_seq} of epoch {followed.epoch:016x}"
    )
