"""What every message and record is made of: their bases and the types of single fields."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

U64 = Annotated[int, msgspec.Meta(ge=0)]  # msgpack itself bounds it by 2**64 - 1
U32 = Annotated[int, msgspec.Meta(ge=0, le=2**32 - 1)]
U8 = Annotated[int, msgspec.Meta(ge=0, le=255)]
Hash32 = Annotated[bytes, msgspec.Meta(min_length=32, max_length=32)]
V1 = Literal[1]

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
