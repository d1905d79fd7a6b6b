"""Bytes that are not the message: always a `MessageError`, never a guess, never a crash."""

from __future__ import annotations

import re

import msgspec
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fairlead.errors import MessageError
from fairlead.messages import (
    MESSAGE_TYPES,
    Done,
    GoalFeedback,
    Heartbeat,
    JointState,
    LayoutState,
    Lease,
    Message,
    decode,
    encode,
)
from tests.golden.instances import MESSAGES

SMALL = {name: message for name, message in MESSAGES.items() if len(encode(message)) < 1000}


def refused(kind: type[Message], frame: bytes) -> str:
    """The complaint about a frame that must be refused."""
    with pytest.raises(MessageError) as caught:
        decode(kind, frame)
    return str(caught.value)


def test_another_type_is_refused_by_name() -> None:
    frame = encode(MESSAGES["Lease"])
    assert (
        refused(JointState, frame) == f"expected JointState v1, got Lease v1 ({len(frame)} bytes)"
    )


def test_another_version_is_refused_by_number() -> None:
    frame = msgspec.msgpack.encode([13, 2, 7])
    assert refused(Heartbeat, frame) == "expected Heartbeat v1, got Heartbeat v2 (4 bytes)"


def test_an_unknown_type_is_refused_by_its_id() -> None:
    frame = msgspec.msgpack.encode([99, 1, 7])
    assert refused(Heartbeat, frame) == "expected Heartbeat v1, got unknown type 99 v1 (4 bytes)"


def test_a_field_that_does_not_fit_is_named_by_its_path() -> None:
    fields = msgspec.msgpack.decode(encode(MESSAGES["Done"]))
    text = refused(Done, msgspec.msgpack.encode([*fields[:2], 5]))
    assert text == "Done: Expected `str`, got `int` - at `$.text` (4 bytes)"


def test_bytes_behind_the_end_are_refused() -> None:
    frame = encode(MESSAGES["Heartbeat"]) + b"\x00"
    assert "trailing characters" in refused(Heartbeat, frame)


def test_a_negative_id_is_refused() -> None:
    assert "Expected `int` >= 0" in refused(Heartbeat, msgspec.msgpack.encode([13, 1, -1]))


def test_a_hash_of_31_bytes_is_refused() -> None:
    fields = msgspec.msgpack.decode(encode(MESSAGES["Lease"]))
    fields[5] = bytes(31)
    assert "length >= 32" in refused(Lease, msgspec.msgpack.encode(fields))


def test_text_that_is_not_utf8_is_refused() -> None:
    assert "utf-8" in refused(Done, encode(Done(text="abcd"))[:-1] + b"\xff")


def test_an_unknown_word_is_refused() -> None:
    fields = msgspec.msgpack.decode(encode(MESSAGES["GoalFeedback.result"]))
    fields[-1][0] = "won"
    assert "Invalid enum value 'won'" in refused(GoalFeedback, msgspec.msgpack.encode(fields))


@pytest.mark.parametrize("values_and_fault", [(None, None), (b"", ["k", "n", "p", 0, "t"])])
def test_a_layout_with_both_or_neither_of_values_and_fault_is_refused(
    values_and_fault: tuple[object, object],
) -> None:
    fields = msgspec.msgpack.decode(encode(MESSAGES["LayoutState"]))
    frame = msgspec.msgpack.encode([*fields[:-2], *values_and_fault])
    assert "exactly one of values and fault must be set" in refused(LayoutState, frame)


def test_a_nest_of_100000_arrays_is_refused() -> None:
    assert refused(Lease, b"\x91" * 100_000).endswith("(100000 bytes)")


def test_an_announced_length_of_4_billion_is_refused_without_allocating_it() -> None:
    assert "truncated" in refused(Lease, encode(MESSAGES["Lease"])[:-1] + b"\xdd\xff\xff\xff\xff")


@pytest.mark.parametrize("name", SMALL)
def test_every_shorter_prefix_is_refused(name: str) -> None:
    frame = encode(MESSAGES[name])
    for length in range(len(frame)):
        refused(type(MESSAGES[name]), frame[:length])


@pytest.mark.parametrize("name", SMALL)
def test_every_flipped_bit_raises_nothing_but_a_message_error(name: str) -> None:
    kind, frame = type(MESSAGES[name]), encode(MESSAGES[name])
    for bit in range(8 * len(frame)):
        flipped = bytearray(frame)
        flipped[bit // 8] ^= 1 << (bit % 8)
        try:
            message = decode(kind, bytes(flipped))
        except MessageError:
            continue
        assert type(message) is kind


@pytest.mark.parametrize("kind", MESSAGE_TYPES, ids=lambda kind: kind.__name__)
def test_no_other_types_frame_is_taken_for_this_one(kind: type[Message]) -> None:
    for message in MESSAGES.values():
        if type(message) is not kind:
            text = refused(kind, encode(message))
            assert re.match(f"expected {kind.__name__} v1, got {type(message).__name__} v1 ", text)


@given(st.sampled_from(MESSAGE_TYPES), st.binary(max_size=200))
@example(JointState, b"")
@example(JointState, b"\xc1")
def test_random_bytes_raise_nothing_but_a_message_error(kind: type[Message], frame: bytes) -> None:
    try:
        message = decode(kind, frame)
    except MessageError:
        return
    assert decode(kind, encode(message)) == message
