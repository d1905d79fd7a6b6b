"""Frames that every codec must refuse, made from the golden bytes by one defect each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import msgspec

from fairlead.messages import Message, encode


@dataclass(frozen=True)
class BadFrame:
    """Bytes that are not a ``kind``; ``defect`` says what was done to a good frame."""

    kind: str
    defect: str
    data: bytes


def bad_frames(messages: dict[str, Message]) -> Iterator[BadFrame]:
    """One frame per defect and per message type (of the rich instances)."""
    for name, message in messages.items():
        if "." not in name:
            for defect, data in _defects(message):
                yield BadFrame(name, defect, data)


def _defects(message: Message) -> Iterator[tuple[str, bytes]]:
    good = encode(message)
    fields: list[object] = msgspec.msgpack.decode(good)
    yield "empty", b""
    yield "last byte missing", good[:-1]
    yield "one byte behind the end", good + b"\x00"
    yield "the frame twice", good + good
    yield "type id one higher", _array([int(message.__struct_config__.tag or 0) + 1, *fields[1:]])
    yield "type id is text", _array(["1", *fields[1:]])
    yield "version 0", _array([fields[0], 0, *fields[2:]])
    yield "version 2", _array([fields[0], 2, *fields[2:]])
    yield "one field more", _array([*fields, 0])
    yield "a map instead of an array", msgspec.msgpack.encode({"type": fields[0]})
    yield "nil", b"\xc0"
    if len(fields) > 2:
        known = msgspec.structs.fields(message)
        optional = sum(not one.required for one in known) - 1  # version has a default too
        yield "last field missing", _array(fields[: len(fields) - optional - 1])
        yield "first field is nil", _array([*fields[:2], None, *fields[3:]])


def _array(fields: list[object]) -> bytes:
    return msgspec.msgpack.encode(fields)
