"""What one claim may execute: its active chunk and those that wait for their first tick."""

from __future__ import annotations

from collections.abc import Sequence

from fairlead.hal.released_chunk import ReleasedChunk
from fairlead.messages import HELD, Acted

MAX_PENDING = 16
"""Chunks kept per claim before their first tick; the gate has at most a few in flight."""


class ClaimRows:
    """Rows of one claim.

    A chunk takes over only at its first tick, and only if it continues what the claim
    really did in the tick before.
    """

    def __init__(self, claim_id: int, epoch: int) -> None:
        self.claim_id = claim_id
        self.epoch = epoch
        self.parts: frozenset[int] = frozenset()
        self.acted: Acted = HELD
        self._active: ReleasedChunk | None = None
        self._pending: dict[int, ReleasedChunk] = {}

    @property
    def is_empty(self) -> bool:
        """Whether nothing is left to execute."""
        return self._active is None and not self._pending

    def store(self, chunk: ReleasedChunk) -> str:
        """Keep a chunk until its first tick. Returns "" or why it is not needed."""
        if self._active is not None and chunk.verdict_id <= self._active.verdict_id:
            return "chunk superseded"
        if chunk.verdict_id in self._pending:
            return "chunk already known"
        self._pending[chunk.verdict_id] = chunk
        self.parts = chunk.part_indices
        if len(self._pending) > MAX_PENDING:
            del self._pending[min(self._pending)]
        return ""

    def candidate(self, tick: int, acted: Sequence[Acted]) -> ReleasedChunk | None:
        """The chunk whose row is for ``tick``, None if there is none.

        The highest verdict that starts now and continues ``acted`` (per part, what was done
        in ``tick - 1``), else the active one.
        """
        for verdict_id in sorted(self._pending, reverse=True):
            chunk = self._pending[verdict_id]
            if chunk.first_tick == tick and self._continues(chunk, acted):
                return chunk
        if self._active is not None and self._active.row_at(tick) is not None:
            return self._active
        return None

    def named(self, verdict_id: int, tick: int, acted: Sequence[Acted]) -> ReleasedChunk | None:
        """The chunk of exactly this verdict, if it may act in ``tick``."""
        active = self._active
        if active is not None and active.verdict_id == verdict_id:
            return active if active.row_at(tick) is not None else None
        chunk = self._pending.get(verdict_id)
        if chunk is not None and chunk.first_tick == tick and self._continues(chunk, acted):
            return chunk
        return None

    def has_due(self, tick: int) -> bool:
        """Whether a chunk starts at ``tick`` (whatever it continues)."""
        return any(chunk.first_tick == tick for chunk in self._pending.values())

    def commit(self, tick: int, chunk: ReleasedChunk | None, acted: Acted) -> None:
        """Record what was done in ``tick``. A held tick (``chunk`` None) discards the rows."""
        self._active = chunk
        self.acted = acted
        newest = chunk.verdict_id if chunk is not None else 0
        if chunk is not None:
            self.parts = chunk.part_indices
        self._pending = {
            verdict_id: pending
            for verdict_id, pending in self._pending.items()
            if pending.first_tick > tick and verdict_id > newest
        }

    def forget(self) -> None:
        """The tick before is unknown: nothing stored can continue it."""
        self._active = None
        self.acted = HELD

    def _continues(self, chunk: ReleasedChunk, acted: Sequence[Acted]) -> bool:
        """Whether the chunk follows on what its parts did in the tick before.

        Two holds match whatever their codes; rows match by verdict and row, also where
        that row was another claim's (one ended while the world stood). A part that the row
        before did not address has held beside it, as the gate knows.
        """
        if self._active is not None and chunk.verdict_id <= self._active.verdict_id:
            return False
        parts_before = [acted[part] for part in chunk.part_indices]
        if chunk.after.hold:
            return bool(self.acted.hold) and all(part.hold for part in parts_before)
        return chunk.after in (self.acted, *parts_before) and all(
            part.hold or part == chunk.after for part in parts_before
        )
