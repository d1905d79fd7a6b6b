"""Does the gate still grant our claim? Read from leases alone."""

from __future__ import annotations

from fairlead.messages import GateState, Lease

_LEASES_BEFORE_GRANT = 80  # leases come at least every 25 ms: 2 s


class ClaimWatch:
    """Follows the leases of the claim's epoch, in their order, and says when it is lost."""

    def __init__(self, source: str, claim_id: int, epoch: int, session: int) -> None:
        self._source = source
        self._claim_id = claim_id
        self._epoch = epoch
        self._session = session
        self._lease_seq = 0
        self._granted = False
        self._without = 0

    def lost(self, lease: Lease) -> str:
        """Why the claim is gone, judged by this lease; "" while it stands."""
        if lease.epoch != self._epoch:
            # Before the first lease of our epoch this is a late one of an earlier epoch.
            return self._words("the gate started a new epoch") if self._lease_seq else ""
        if lease.lease_seq <= self._lease_seq:
            return ""
        self._lease_seq = lease.lease_seq
        if lease.session != self._session:
            return self._words("the gate follows another HAL session")
        if lease.state != GateState.ARMED:
            return self._words(f"the gate is {_name(lease.state)}")
        if any(grant.claim_id == self._claim_id for grant in lease.grants):
            self._granted, self._without = True, 0
            return ""
        self._without += 1
        if self._granted:
            return self._words("the gate no longer grants it")
        if self._without > _LEASES_BEFORE_GRANT:
            return self._words("the gate never granted it")
        return ""

    def _words(self, what: str) -> str:
        return f"claim of {self._source} lost: {what}"


def _name(state: int) -> str:
    try:
        return GateState(state).name.lower()
    except ValueError:
        return f"in state {state}"
