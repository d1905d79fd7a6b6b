"""``trace.jsonl``: what the policy saw and said, bit for bit, one line per call.

Of a skill with a seam also what was proposed of it, for that is not what the policy said.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

import msgspec
import numpy as np

from fairlead.errors import ConfigError
from fairlead.line_writer import LineWriter
from fairlead.messages import FloatArray
from fairlead.policy import Actions, Observation
from fairlead.regular_file import regular


class _Line(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    tick: int
    state: str  # hex, little-endian float64 [state dim]
    actions: str  # hex, little-endian float32 [horizon, dim], row-major
    horizon: int
    dim: int
    sent: str = ""  # as actions; empty: the same
    chunk: str = ""  # hex, the ActionChunk; empty: its rows are as sent
    pictures: dict[str, str] = {}  # by name, as `picture_hashes`


@dataclass(frozen=True)
class TraceRecord:
    """One policy call: the observation's tick and state, and the raw actions.

    sent: the actions after clips and thresholds of their slots; None: the same.
    chunk: the encoded `ActionChunk` if its seam was to be blended, else empty.
    pictures: of what the policy saw, see `picture_hashes`.
    """

    tick: int
    state: FloatArray
    actions: Actions
    sent: Actions | None = None
    chunk: bytes = b""
    pictures: Mapping[str, str] = field(default_factory=dict)

    @property
    def proposed(self) -> Actions:
        """What became the chunk, but for its seam: ``sent``, or else the actions as they are."""
        return self.actions if self.sent is None else self.sent


def picture_hashes(seen: Observation) -> dict[str, str]:
    """By picture, SHA-256 (hex) of type, shape and pixels of all its frames, as the policy gets."""
    found = {}
    for name in seen.images:
        frames = np.ascontiguousarray(seen.frames_of(name))
        found[name] = sha256(
            f"{frames.dtype.str}{frames.shape}".encode() + frames.tobytes()
        ).hexdigest()
    return found


class TraceWriter:
    """Appends records to a file, afresh; what the disk does delays and ends nothing else."""

    def __init__(self, path: Path) -> None:
        self._lines = LineWriter(path, afresh=True)

    def write(self, record: TraceRecord) -> None:
        """Append one record; returns at once."""
        horizon, dim = record.actions.shape
        line = _Line(
            tick=record.tick,
            state=np.ascontiguousarray(record.state, dtype="<f8").tobytes().hex(),
            actions=_hex(record.actions),
            horizon=horizon,
            dim=dim,
            sent="" if record.sent is None else _hex(record.sent),
            chunk=record.chunk.hex(),
            pictures=dict(record.pictures),
        )
        self._lines.put(msgspec.json.encode(line).decode())

    def close(self) -> None:
        """Write what is queued, for a few seconds at most."""
        self._lines.close()


def _hex(rows: Actions) -> str:
    return np.ascontiguousarray(rows, dtype="<f4").tobytes().hex()


def _rows(text: str, line: _Line) -> Actions:
    return np.frombuffer(bytes.fromhex(text), dtype="<f4").reshape(line.horizon, line.dim)


def read_trace(path: Path) -> Iterator[TraceRecord]:
    """Read a recording.

    Raises:
        ConfigError: naming the file and the line that does not fit.
    """
    try:
        lines = regular(path).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    for number, text in enumerate(lines, start=1):
        try:
            line = msgspec.json.decode(text, type=_Line)
            yield TraceRecord(
                tick=line.tick,
                state=np.frombuffer(bytes.fromhex(line.state), dtype="<f8"),
                actions=_rows(line.actions, line),
                sent=_rows(line.sent, line) if line.sent else None,
                chunk=bytes.fromhex(line.chunk),
                pictures=line.pictures,
            )
        except (msgspec.DecodeError, ValueError) as error:
            raise ConfigError(f"{path} line {number}: not a trace record: {error}") from None
