"""What messages are made of: their bases, the types of single fields, blocks of numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
import numpy as np
import numpy.typing as npt

from fairlead.errors import MessageError

U64 = Annotated[int, msgspec.Meta(ge=0)]  # msgpack itself bounds it by 2**64 - 1
U32 = Annotated[int, msgspec.Meta(ge=0, le=2**32 - 1)]
U8 = Annotated[int, msgspec.Meta(ge=0, le=255)]
Hash32 = Annotated[bytes, msgspec.Meta(min_length=32, max_length=32)]
V1 = Literal[1]

if TYPE_CHECKING:
    Bytes = bytes
else:
    Bytes = memoryview
"""Bytes that are not copied out of the message they came in: pictures."""

NO_HASH = bytes(32)
NO_TRACE = bytes(24)


class Message(
    msgspec.Struct, frozen=True, array_like=True, forbid_unknown_fields=True, kw_only=True
):
    """Base of every message; subclasses add a type id (their tag) and a version."""


class Record(
    msgspec.Struct, frozen=True, array_like=True, forbid_unknown_fields=True, kw_only=True
):
    """Base of the records inside messages: no type id, no version of their own."""


FloatArray = npt.NDArray[np.float64]
_F8 = np.dtype("<f8")


def pack_floats(values: npt.ArrayLike) -> bytes:
    """Encode numbers as the wire's little-endian float64 block, row-major."""
    return np.asarray(values, _F8).tobytes()


def floats(block: bytes, width: int | None = None) -> FloatArray:
    """Decode a float64 block: shape ``[n]``, or ``[rows, width]`` where width is given.

    Raises:
        MessageError: if the block is not a whole number of float64 (or of rows).
    """
    row = 8 * (width or 1)
    if row <= 0 or len(block) % row:
        raise MessageError(f"float block: expected a multiple of {row} bytes, got {len(block)}")
    array = np.frombuffer(block, _F8)
    return array if width is None else array.reshape(-1, width)
