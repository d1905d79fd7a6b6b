"""What claims may execute: their released chunks, and those that wait for their first tick."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from fairlead.errors import MessageError, expected
from fairlead.hal.backend import PartCommand
from fairlead.messages import HELD, Acted, ActionPart, FloatArray, Hold, SafeChunk, floats
from fairlead.modes import GATED_MODES, ControlMode


@dataclass(frozen=True)
class ReleasedPart:
    """The rows of one part: ``values`` is ``[horizon, width]`` SI numbers of ``mode``."""

    part: int
    mode: ControlMode
    frame_id: str
    values: FloatArray
    active: tuple[int, ...]


@dataclass(frozen=True)
class ReleasedChunk:
    """Rows the gate released for one claim; row k is for tick ``first_tick + k``."""

    session: int
    epoch: int
    claim_id: int
    verdict_id: int
    first_tick: int
    horizon: int
    after: Acted
    parts: tuple[ReleasedPart, ...]

    @property
    def part_indices(self) -> frozenset[int]:
        """The parts that the rows command, as indices in robot order."""
        return frozenset(part.part for part in self.parts)

    def row_at(self, tick: int) -> int | None:
        """Index of the row for ``tick``, None where the chunk has none."""
        row = tick - self.first_tick
        return row if 0 <= row < self.horizon else None

    def acted(self, row: int) -> Acted:
        """The record of having executed ``row``."""
        return Acted(hold=Hold.NONE, verdict_id=self.verdict_id, row=row)

    def commands(self, row: int) -> dict[int, PartCommand]:
        """Commands of ``row`` by part index; arrays are copies."""
        return {
            part.part: PartCommand(
                mode=part.mode,
                frame_id=part.frame_id,
                values=part.values[row].copy(),
                active=part.active,
            )
            for part in self.parts
        }


def decode_released(chunk: SafeChunk, part_count: int, n_dof: int) -> ReleasedChunk:
    """Check a SafeChunk against the robot's shape and decode its rows.

    Args:
        part_count: number of parts of the robot.
        n_dof: number of commanded joints, the width of joint modes.

    Raises:
        MessageError: if a part, mode, width or joint index does not exist.
    """
    parts = tuple(_decode_part(part, chunk.horizon, part_count, n_dof) for part in chunk.parts)
    indices = [part.part for part in parts]
    if not parts or chunk.horizon < 1 or len(set(indices)) != len(indices):
        raise MessageError(
            expected(
                "SafeChunk",
                "rows for at least one part, each part once",
                f"horizon {chunk.horizon}, parts {indices}",
            )
        )
    return ReleasedChunk(
        session=chunk.session,
        epoch=chunk.epoch,
        claim_id=chunk.claim_id,
        verdict_id=chunk.verdict_id,
        first_tick=chunk.first_tick,
        horizon=chunk.horizon,
        after=chunk.after,
        parts=parts,
    )


def _decode_part(part: ActionPart, horizon: int, part_count: int, n_dof: int) -> ReleasedPart:
    if part.part >= part_count:
        raise MessageError(expected("SafeChunk", f"part < {part_count}", part.part))
    try:
        mode = ControlMode(part.mode)
    except ValueError:
        raise MessageError(expected("SafeChunk", "a known mode", part.mode)) from None
    if mode not in GATED_MODES:
        valid = sorted(gated.yaml_name for gated in GATED_MODES)
        raise MessageError(expected("SafeChunk", "a mode the gate checks", mode.yaml_name, valid))
    width = mode.width(n_dof)
    if len(part.values) != 8 * width * horizon:
        raise MessageError(
            expected(
                "SafeChunk", f"{horizon} rows of {mode.yaml_name}", f"{len(part.values)} bytes"
            )
        )
    if any(joint >= n_dof for joint in part.active):
        raise MessageError(expected("SafeChunk", f"joints < {n_dof}", part.active))
    return ReleasedPart(
        part=part.part,
        mode=mode,
        frame_id=part.frame_id,
        values=floats(part.values, width),
        active=tuple(part.active),
    )


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

    def drop_rows(self) -> None:
        """Nothing that was released is executed any more."""
        self._active = None
        self._pending.clear()

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

    def drop_rows(self) -> None:
        """Forget every released row, those that wait for their first tick too."""
        for claim in self:
            claim.drop_rows()

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
