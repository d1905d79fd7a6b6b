"""What the gate that is followed cannot have sent: it is a second one's, or forged."""

from __future__ import annotations

from fairlead.hal.claims import ClaimTable
from fairlead.hal.lease_follower import LeaseFollower
from fairlead.messages import Lease, SafeChunk


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
