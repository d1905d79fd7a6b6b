"""Decision logs as records, read and written: the layout of `fairlead_tools.record.run_log`."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

FIRST_LINE = b"fairlead-decisions-2\n"
HEADER, BOOT, STEP, TIMER, GAP, END = 1, 2, 3, 4, 5, 6
HEADER_BYTES = 100_000  # of a file: its header, with the configuration, is in them
_HEAD_BYTES, _CRC_BYTES, _CHECK = 5, 4, 0xA5
_TIMES_BYTES = 20


@dataclass(frozen=True)
class LogRecord:
    """One record: its type, and its body as it stands in the file."""

    type: int
    body: bytes

    @property
    def frame(self) -> bytes:
        """As it stands in the file, without the CRC behind it."""
        head = bytes((self.type,)) + len(self.body).to_bytes(3, "little")
        check = _CHECK
        for byte in head:
            check ^= byte
        return head + bytes((check,)) + self.body


@dataclass(frozen=True)
class StepFacts:
    """What a step was given, and the outputs that the log keeps: kind, payload."""

    kind: int
    payload: bytes
    outputs: tuple[tuple[int, bytes], ...]


def read_log(path: Path, most_bytes: int = -1) -> list[LogRecord]:
    """The records up to the first byte that is not what was written; [] if it is no log.

    most_bytes: of the file; all of it if negative.
    """
    with path.open("rb") as file:
        data = file.read(most_bytes)
    if not data.startswith(FIRST_LINE):
        return []
    records, place, crc = [], len(FIRST_LINE), zlib.crc32(FIRST_LINE)
    while place + _HEAD_BYTES + _CRC_BYTES <= len(data):
        end = place + _HEAD_BYTES + int.from_bytes(data[place + 1 : place + 4], "little")
        crc = zlib.crc32(data[place:end], crc)
        if data[end : end + _CRC_BYTES] != crc.to_bytes(_CRC_BYTES, "little"):
            break
        records.append(LogRecord(data[place], data[place + _HEAD_BYTES : end]))
        place = end + _CRC_BYTES
    return records


def write_log(path: Path, records: Iterable[LogRecord]) -> None:
    """A log that the gate reads."""
    data, crc = bytearray(FIRST_LINE), zlib.crc32(FIRST_LINE)
    for record in records:
        frame = record.frame
        crc = zlib.crc32(frame, crc)
        data += frame + crc.to_bytes(_CRC_BYTES, "little")
    path.write_bytes(data)


def config_text(records: list[LogRecord]) -> str:
    """The configuration that decided; "" of a log that no gate wrote, as tests make them."""
    try:
        return str(json.loads(records[0].body)["config"])
    except (ValueError, KeyError):
        return ""


def step_facts(record: LogRecord) -> StepFacts:
    """What a step record says."""
    body, place = record.body, _TIMES_BYTES
    kind = body[place]
    place += 2 + body[place + 1]
    payload, place = _sized(body, place)
    place += 1 + 8 * body[place]  # ids
    outputs = []
    if body[place] > 0:
        kept = body[place + 17]  # behind the digest
        place += 18
        for _ in range(kept):
            output = body[place]
            place += 2 + body[place + 1]
            said, place = _sized(body, place)
            outputs.append((output, said))
    return StepFacts(kind, payload, tuple(outputs))


def _sized(body: bytes, place: int) -> tuple[bytes, int]:
    (size,) = struct.unpack_from("<I", body, place)
    return body[place + 4 : place + 4 + size], place + 4 + size
