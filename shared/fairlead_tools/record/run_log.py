"""A run as the gate's decision log tells it: states, what was asked, what was decided.

The file, little-endian: the line ``fairlead-decisions-2``, a newline, then frames of

    1 byte    type
    3 bytes   length of the body
    1 byte    XOR of the four bytes before and 0xA5
              body
    4 bytes   CRC-32 of the file up to here, without the CRCs

    type      body
    1 header  JSON: robot, profile, gate (SHA-256 of the program), started (UTC), config_file,
              config (its text)
    2 boot    u64 now, u8 first start, u8 clean mark, u8 new state, u32 size and latch record,
              results
    3 step    u64 now, u64 received, u32 ns of the step before, u8 kind of event, u8 size and
              source, u32 size and payload, results
    4 timer   u64 now, u32 ns of the step before: a timer step without ids and outputs
    5 gap     u64 records lost
    6 end     why, in words; without it the gate was killed, or still runs

Results: u8 count and random ids drawn (u64 each); u8 count of outputs; if any, 16 bytes of the
SHA-256 of all, u8 count of those kept, each u8 kind, u8 size and source, u32 size and payload.
Leases and released rows are not kept: a replay computes them. Times are CLOCK_MONOTONIC in ns;
kinds those of EventKind and OutputKind (services/safety/include/fairlead_safety); payloads
`fairlead.messages`, cut at 65,537 bytes.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from enum import IntEnum
from pathlib import Path

import msgspec

from fairlead.errors import ConfigError, MessageError, NoAnswerError
from fairlead.messages import (
    ActionChunk,
    Claim,
    ClaimReply,
    GateState,
    GateStatus,
    JointState,
    Outcome,
    Verdict,
    decode,
)
from fairlead.regular_file import regular

_FIRST_LINE = b"fairlead-decisions-2\n"


class _Record(IntEnum):
    HEADER = 1
    STEP = 3


class _Event(IntEnum):
    JOINT_STATE = 1
    CANDIDATE = 2
    CLAIM = 9


class _Output(IntEnum):
    VERDICT = 2
    STATUS = 4
    REPLY = 5


class Header(msgspec.Struct):
    """Which robot, under which limits, since when (UTC)."""

    robot: str
    profile: str
    started: str


@dataclass(frozen=True)
class Run:
    """What a gate heard and decided, in order.

    claims: by claim id. verdicts: each with the newest measured tick when it was given.
    stops: tick, cause and HAL session of each stop or latch. damage: why the log ends early, or "".
    """

    header: Header
    joints: list[JointState] = field(default_factory=list)
    chunks: list[ActionChunk] = field(default_factory=list)
    claims: dict[int, Claim] = field(default_factory=dict)
    verdicts: list[tuple[int, Verdict]] = field(default_factory=list)
    stops: list[tuple[int, str, int]] = field(default_factory=list)
    damage: str = ""

    @property
    def tick(self) -> int:
        """The newest measured tick, 0 before the first."""
        return self.joints[-1].tick if self.joints else 0

    def first_verdicts(self) -> dict[tuple[str, int, int], tuple[int, Verdict]]:
        """The first verdict of each chunk and its tick, by source, claim and sequence number.

        A copy sent again is answered again; the first answer is the one that counts.
        """
        first: dict[tuple[str, int, int], tuple[int, Verdict]] = {}
        for tick, verdict in self.verdicts:
            first.setdefault((verdict.source, verdict.claim_id, verdict.seq), (tick, verdict))
        return first

    def released(self) -> Iterator[tuple[ActionChunk, range]]:
        """Each chunk, and the ticks of its rows that its first verdict released."""
        verdicts = self.first_verdicts()
        judged: dict[tuple[str, int, int], ActionChunk] = {}
        for chunk in self.chunks:
            number = (chunk.source, chunk.claim_id, chunk.seq)
            is_judged = judged.setdefault(number, chunk) == chunk  # else: forged
            _, verdict = verdicts.get(number, (0, None))
            ticks = range(0)
            if verdict is not None and verdict.released_first and is_judged:
                ticks = range(verdict.released_first, verdict.released_last + 1)
            yield chunk, ticks

    def outcomes(self, source: str) -> dict[tuple[int, int], str]:
        """Outcome of each chunk of ``source``, by claim and sequence number.

        Chunks that cited no live claim of the source (replays, strangers) are not its own.
        """
        return {
            (claim_id, seq): Outcome(verdict.outcome).name.lower()
            for (whose, claim_id, seq), (_, verdict) in self.first_verdicts().items()
            if whose == source and claim_id
        }

    @property
    def newest_claim(self) -> tuple[int, int, int] | None:
        """HAL session, first and last tick of the chunks of the newest claim that released any.

        Else of the newest chunk's; None where nothing was asked.
        """
        if not self.chunks:
            return None
        released = [one for _, one in self.verdicts if one.released_first]
        newest = released[-1] if released else self.chunks[-1]
        its = [one for one in self.chunks if one.claim_id == newest.claim_id]
        last = max(one.start_tick + one.horizon - 1 for one in its)
        return newest.session, min(one.start_tick for one in its), last

    def between(self, first: int, last: int, session: int) -> Run:
        """Only ticks ``first`` to ``last`` of one session of the HAL."""
        chunks = [
            one for one in self.chunks if one.start_tick <= last and one.session == session
            and one.start_tick + one.horizon > first
        ]  # fmt: skip
        kept = {(one.source, one.claim_id, one.seq) for one in chunks}
        return replace(
            self,
            joints=[
                one for one in self.joints if first <= one.tick <= last and one.session == session
            ],
            chunks=chunks,
            verdicts=[
                (tick, one) for tick, one in self.verdicts
                if (first <= tick <= last and one.session in (0, session))
                or (one.source, one.claim_id, one.seq) in kept
            ],
            stops=[one for one in self.stops if first <= one[0] <= last and one[2] == session],
        )  # fmt: skip


def newest_log(folder: Path) -> Path:
    """The decision log in or below a folder that was written last.

    Raises:
        NoAnswerError: there is none.
    """
    found = sorted(folder.rglob("*.decisions"), key=lambda path: path.stat().st_mtime_ns)
    if not found:
        raise NoAnswerError(f"no decision log in {folder}; a running gate writes one")
    return found[-1]


def read_run(path: Path) -> Run:
    """Read a decision log, up to where it is damaged or not yet written.

    Raises:
        ConfigError: it cannot be read, or is no decision log of this layout.
    """
    try:
        data = regular(path).read_bytes()
    except OSError as error:
        raise ConfigError(f"decision log {path}: {error.strerror}") from None
    if not data.startswith(_FIRST_LINE):
        want, got = _FIRST_LINE[:-1].decode(), data[:40].split(b"\n")[0].decode(errors="replace")
        raise ConfigError(f"decision log {path}: expected its first line to be {want}, got {got!r}")
    frames = _Frames(data)
    kind, body = next(iter(frames), (0, b""))
    if kind != _Record.HEADER:
        raise ConfigError(f"decision log {path}: its first record, the header, is missing")
    try:
        run = Run(msgspec.json.decode(body, type=Header))
        state = GateState.BOOT
        for kind, body in frames:
            if kind == _Record.STEP:
                state = _take(run, body, state)
    except (msgspec.MsgspecError, struct.error, ValueError, MessageError) as error:
        raise ConfigError(f"decision log {path}: not as a gate writes it: {error}") from None
    return replace(run, damage=frames.damage)


class _Frames:
    """Type and body of each record."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, len(_FIRST_LINE)
        self._crc = zlib.crc32(_FIRST_LINE)
        self.damage = ""

    def __iter__(self) -> Iterator[tuple[int, bytes]]:
        return self

    def __next__(self) -> tuple[int, bytes]:
        at, data = self._at, self._data
        head = data[at : at + 5]
        if len(head) == 5 and head[0] ^ head[1] ^ head[2] ^ head[3] ^ 0xA5 != head[4]:
            self.damage = self.damage or f"damaged in the record at byte {at}"
        end = at + 5 + int.from_bytes(data[at + 1 : at + 4], "little")
        if at >= len(data) or self.damage:
            raise StopIteration
        if end + 4 > len(data):  # the gate still writes, or was killed
            self.damage = f"cut off in a record at byte {at}"
            raise StopIteration
        self._crc = zlib.crc32(data[at:end], self._crc)
        if self._crc != int.from_bytes(data[end : end + 4], "little"):
            self.damage = f"damaged in the record at byte {at}"
            raise StopIteration
        self._at = end + 4
        return data[at], data[at + 5 : end]


class _Body:
    """Reads a record's fields one after the other."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def number(self, code: str) -> int:
        (value,) = struct.unpack_from(f"<{code}", self._data, self._at)
        self._at += struct.calcsize(f"<{code}")
        return int(value)

    def sized(self, code: str) -> bytes:
        size = self.number(code)
        self._at += size
        return self._data[self._at - size : self._at]

    def skip(self, size: int) -> None:
        self._at += size


def _take(run: Run, data: bytes, state: GateState) -> GateState:
    """Add what one step was given and put out; returns the gate's state after it."""
    body = _Body(data)
    body.skip(8 + 8 + 4)
    event = body.number("B")
    body.skip(body.number("B"))
    given = body.sized("I")
    try:
        if event == _Event.JOINT_STATE:
            measured = decode(JointState, given)
            if measured.tick != run.tick:  # while the world waits, the HAL repeats its newest tick
                run.joints.append(measured)
        elif event == _Event.CANDIDATE:
            run.chunks.append(decode(ActionChunk, given))
    except MessageError:  # the gate refused it too; its verdict says so
        pass
    for kind, payload in _outputs(body):
        if kind == _Output.VERDICT:
            run.verdicts.append((run.tick, decode(Verdict, payload)))
        elif kind == _Output.REPLY and event == _Event.CLAIM:
            run.claims[decode(ClaimReply, payload).claim_id] = decode(Claim, given)
        elif kind == _Output.STATUS:
            status = decode(GateStatus, payload)
            if status.state != state and status.state >= GateState.STOPPED:
                run.stops.append((run.tick, status.cause, status.session))
            state = GateState(status.state)
    return state


def _outputs(body: _Body) -> Iterator[tuple[int, bytes]]:
    body.skip(8 * body.number("B"))
    if not body.number("B"):
        return
    body.skip(16)
    for _ in range(body.number("B")):
        kind = body.number("B")
        body.skip(body.number("B"))
        yield kind, body.sized("I")
