"""One SafeChunk, decoded once on arrival into the rows a backend can execute."""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.errors import MessageError, expected
from fairlead.hal.backend import PartCommand
from fairlead.messages import Acted, ActionPart, FloatArray, Hold, SafeChunk, floats
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
