"""What a gate's decision log says about a decision, as ``fairlead-decisions explain`` reads it.

The gate's own program reads the log and, for what would have passed, asks the gate's own code
again; here it is only decoded. Ids are hex.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Literal

import msgspec

from fairlead.errors import ConfigError, ServiceError
from fairlead.paths import decisions_binary

Number = float | Literal["nan", "inf", "-inf"]
_PATIENCE_S = 300.0
_BLAME = "ERROR fairlead-decisions: "


class ChunkPart(msgspec.Struct, frozen=True):
    """One part a chunk addressed; ``frame`` is "" for joint modes."""

    part: str
    mode: str
    frame: str


class Chunk(msgspec.Struct, frozen=True):
    """What was asked: ``rows`` rows from ``start_tick`` on, made from the state of ``obs_tick``.

    ``skill`` is that of the claim, "" if it was made before the log begins. ``mode`` is that
    of the verdict's part, "" if it names none.
    """

    goal_id: str
    skill: str
    obs_tick: int
    start_tick: int
    rows: int
    parts: tuple[ChunkPart, ...]
    mode: str = ""


class Judged(msgspec.Struct, frozen=True):
    """The fields of a verdict, as in ``fairlead.messages.Verdict``; no unit in an older log."""

    source: str
    seq: int
    outcome: Literal["released", "truncated", "refused"]
    code: int
    row: int
    part: str
    axis: str
    value: Number
    limit: Number
    margin: Number
    limit_source: str
    released_first: int
    released_last: int
    unit: str = ""


class Passes(msgspec.Struct, frozen=True):
    """A change with which the gate releases the whole chunk; it was asked, nothing is estimated.

    change: ``row``: only the verdict's axis in its row; ``rows``: every number of the part;
    ``rounded``: every number of the part 0 or 1, whichever is nearer; ``none``: not even at rest,
    for what ``still`` says.
    scale: the largest factor that passes. It applies about the row before where ``about_row``,
    else about rest: zero for deltas and velocities, what is measured for positions and poses.
    asked, number: of ``row``: the number or norm that was asked for, and the largest that passes.
    """

    change: Literal["row", "rows", "rounded", "none"]
    scale: float | None = None
    about_row: bool = False
    asked: float | None = None
    number: float | None = None
    still: Judged | None = None


class Nearest(msgspec.Struct, frozen=True):
    """How far a released part was from refusal: ``scale`` times its numbers about rest pass.

    ``scale`` is None if 100 times would pass too; ``beyond`` is the verdict just above it.
    """

    part: str
    scale: float | None = None
    beyond: Judged | None = None


class Answer(Judged, frozen=True, tag_field="kind", tag="verdict"):
    """One verdict and its circumstances.

    tick: newest state when it was given.
    judged_again: rows released before were judged again: the HAL did something else, or a newer
        state showed that they would lead too far.
    chunk: None if the log does not have it.
    would_pass, nearest: None where that was not asked.
    """

    tick: int = 0
    judged_again: bool = False
    chunk: Chunk | None = None
    would_pass: Passes | None = None
    nearest: tuple[Nearest, ...] | None = None


class _Ended(msgspec.Struct, frozen=True):
    """The gate's state after it stopped or latched, and the command that resets it."""

    tick: int
    cause: str
    fix: str
    stop_ids: tuple[str, ...]
    latch_id: str


class Stop(_Ended, frozen=True, tag_field="kind", tag="stop"):
    """The gate stopped."""


class Latch(_Ended, frozen=True, tag_field="kind", tag="latch"):
    """The gate latched."""


class GateNow(msgspec.Struct, frozen=True):
    """The newest status in the log."""

    state: str
    cause: str
    fix: str
    stop_ids: tuple[str, ...]
    latch_id: str


class Explanation(msgspec.Struct, frozen=True):
    """The answer to one question about one log.

    read: how the log ends, in words.
    lost: records that could not be written.
    tick: newest state in it.
    status: None if the log has none.
    """

    log: str
    robot: str
    profile: str
    started: str
    config_file: str
    read: str
    lost: int
    tick: int
    verdicts: int
    status: GateNow | None
    decisions: tuple[Answer | Stop | Latch, ...]


def explain(log: Path, tick: int | None = None, source: str | None = None) -> Explanation:
    """Ask about decisions of one tick, or about the last refusal and what followed.

    Args:
        log: a ``*.decisions`` file, or a folder of them: its newest.
        tick: decisions made at this tick or about a row for it.
        source: only chunks of this runner.

    Raises:
        ConfigError: the log cannot be read, or the gate is not built.
    """
    command = [str(decisions_binary()), "explain", str(log)]
    if tick is not None:
        command += ["--tick", str(tick)]
    if source is not None:
        command += ["--source", source]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_PATIENCE_S, check=False
        )
    except subprocess.TimeoutExpired:
        raise ServiceError(f"explain: took longer than {_PATIENCE_S:g} s; give a tick") from None
    if done.returncode != 0:
        words = (done.stdout + done.stderr).strip()
        raise ConfigError(words.removeprefix(_BLAME) or f"explain ended with {done.returncode}")
    return msgspec.json.decode(done.stdout, type=Explanation)
