"""The claims whose rows a HAL keeps, and which of them it lets go."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from fairlead.hal.claim_rows import ClaimRows
from fairlead.hal.released_chunk import ReleasedChunk
from fairlead.messages import Acted

MAX_CLAIMS = 16
"""Claims whose rows are kept at once; a robot has fewer parts than that to claim."""


class ClaimTable:
    """Rows by claim. A claim appears with its first chunk, in the order of arrival."""

    def __init__(self) -> None:
        self._claims: dict[int, ClaimRows] = {}

    def __iter__(self) -> Iterator[ClaimRows]:
        return iter(tuple(self._claims.values()))

    def get(self, claim_id: int) -> ClaimRows | None:
        """The rows of one claim, None if no chunk of it has come."""
        return self._claims.get(claim_id)

    def store(self, chunk: ReleasedChunk, granted: Collection[int]) -> str:
        """Keep a chunk until its first tick. Returns "" or why it is not needed.

        Args:
            granted: ids of the claims in the newest lease: the last to make room.
        """
        claim = self._claims.get(chunk.claim_id)
        if claim is None:
            self._make_room(granted)
            claim = self._claims[chunk.claim_id] = ClaimRows(chunk.claim_id, chunk.epoch)
        if claim.epoch != chunk.epoch:
            return "chunk of another epoch than its claim"
        return claim.store(chunk)

    def drop(self, claim: ClaimRows) -> None:
        """Forget one claim and its rows."""
        del self._claims[claim.claim_id]

    def drop_dead(self, granted: Collection[int]) -> None:
        """Forget the claims that have no rows left and are not granted any more."""
        for claim in self:
            if claim.is_empty and claim.claim_id not in granted:
                self.drop(claim)

    def hold_all(self, tick: int, acted: Acted) -> None:
        """Every claim held in ``tick``; its rows are discarded."""
        for claim in self:
            claim.commit(tick, None, acted)

    def forget_rows(self) -> None:
        """The tick before is unknown: nothing stored can continue it."""
        for claim in self:
            claim.forget()

    def _make_room(self, granted: Collection[int]) -> None:
        if len(self._claims) >= MAX_CLAIMS:
            oldest_first = sorted(self, key=lambda known: known.claim_id in granted)
            self.drop(oldest_first[0])
