"""What is encoded comes back: any content of any type, to the byte."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fairlead.errors import MessageError
from fairlead.messages import MESSAGE_TYPES, Message, decode, encode, floats, pack_floats
from tests.wire.strategies import messages


@pytest.mark.parametrize("kind", MESSAGE_TYPES, ids=lambda kind: kind.__name__)
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_any_message_survives_the_wire(kind: type[Message], data: st.DataObject) -> None:
    message = data.draw(messages(kind))
    frame = encode(message)
    back = decode(kind, frame)
    assert encode(back) == frame
    assert back == message or "nan" in repr(message)


@pytest.mark.parametrize("kind", MESSAGE_TYPES, ids=lambda kind: kind.__name__)
@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_a_decoded_message_is_immutable_and_hashable(
    kind: type[Message], data: st.DataObject
) -> None:
    message = data.draw(messages(kind))
    hash(message)
    with pytest.raises(AttributeError):
        message.version = 2  # type: ignore[attr-defined]


@given(st.lists(st.floats(), max_size=60))
def test_float_block_keeps_every_bit(numbers: list[float]) -> None:
    back = floats(pack_floats(numbers)).tolist()
    assert [math.copysign(1, x) for x in back] == [math.copysign(1, x) for x in numbers]
    assert np.array_equal(back, numbers, equal_nan=True)


def test_float_block_is_little_endian_and_row_major() -> None:
    assert pack_floats([1.0]) == bytes.fromhex("000000000000f03f")
    assert floats(pack_floats([[1.0, 2.0], [3.0, 4.0]]), width=2).tolist() == [[1, 2], [3, 4]]


@pytest.mark.parametrize(
    ("size", "width", "text"),
    [
        (7, None, "float block: expected a multiple of 8 bytes, got 7"),
        (40, 6, "float block: expected a multiple of 48 bytes, got 40"),
    ],
)
def test_float_block_of_a_part_of_a_row_is_refused(size: int, width: int | None, text: str) -> None:
    with pytest.raises(MessageError, match=f"^{text}$"):
        floats(bytes(size), width)
