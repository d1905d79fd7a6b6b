"""Every message by its type id, to bytes and back; what does not fit is refused, and why."""

from __future__ import annotations

import re
import struct
from typing import Any, TypeVar

import msgspec

from fairlead.errors import MessageError
from fairlead.messages.action import ActionChunk, ActionPart, SafeChunk
from fairlead.messages.gate import (
    Claim,
    ClaimInfo,
    ClaimReply,
    GateStatus,
    Grant,
    Heartbeat,
    Lease,
    LimitOverride,
    Release,
    Verdict,
)
from fairlead.messages.goal import Cancel, Goal, GoalAccepted, GoalFeedback, GoalResult, Load
from fairlead.messages.message import U64, Bytes, Message, Record
from fairlead.messages.operation import (
    Arm,
    ArmReply,
    Disarm,
    Done,
    Refusal,
    Reset,
    ResetEpisode,
    ResetEpisodeReply,
    StatusQuery,
    StopLevel,
)
from fairlead.messages.state import (
    Acted,
    HalCamera,
    HalPart,
    HalStatus,
    Image,
    JointState,
    LayoutFault,
    LayoutState,
    ModeRange,
    TaskState,
    Transform,
    TransformBatch,
)

MESSAGE_TYPES: tuple[type[Message], ...] = (
    JointState,
    TransformBatch,
    Image,
    TaskState,
    HalStatus,
    LayoutState,
    ActionChunk,
    SafeChunk,
    Lease,
    Verdict,
    GateStatus,
    StopLevel,
    Heartbeat,
    Refusal,
    Done,
    StatusQuery,
    Arm,
    ArmReply,
    Disarm,
    Reset,
    Claim,
    ClaimReply,
    Release,
    ResetEpisode,
    ResetEpisodeReply,
    Goal,
    GoalAccepted,
    Cancel,
    GoalFeedback,
    Load,
)
"""Every message type, by type id."""

RECORD_TYPES: tuple[type[Record], ...] = (
    Acted,
    Transform,
    ModeRange,
    HalPart,
    HalCamera,
    LayoutFault,
    ActionPart,
    Grant,
    ClaimInfo,
    LimitOverride,
    GoalResult,
)
"""Every record that stands inside messages."""


_ENCODER = msgspec.msgpack.Encoder()

_DECODERS: dict[type[Message], msgspec.msgpack.Decoder[Any]] = {
    kind: msgspec.msgpack.Decoder(kind) for kind in MESSAGE_TYPES
}

_NO_BYTES = _ENCODER.encode(b"")
_HEAD = msgspec.msgpack.Decoder(list[msgspec.Raw])
_UINT = msgspec.msgpack.Decoder(U64)
_NAMES = {kind.__struct_config__.tag: kind.__name__ for kind in MESSAGE_TYPES}

M = TypeVar("M", bound=Message)


def encode(message: Message) -> bytes:
    """Encode one message for the wire.

    Raises:
        MessageError: a number beyond 64 bits, text that is no UTF-8, or what is no message's field.
    """
    try:
        return _ENCODER.encode(message)
    except (OverflowError, TypeError, ValueError) as error:
        raise MessageError(f"{type(message).__name__}: cannot be sent: {error}") from None


def check_fields(message: Message) -> None:
    """See that whoever gets a message can read it, as one is made without a look at its fields.

    Raises:
        MessageError: as `encode`, or naming a field of another kind.
    """
    kind, data = type(message), encode(message)
    try:
        _DECODERS[kind].decode(data)
    except ValueError as error:
        raise MessageError(f"{kind.__name__}: cannot be sent: {_told(kind, error)}") from None


def encode_parts(image: Image) -> tuple[bytes, Bytes]:
    """`encode`, in two pieces: all before the pixels, and the pixels themselves."""
    head = encode(msgspec.structs.replace(image, data=b""))[: -len(_NO_BYTES)]
    size = len(image.data)
    if size < 2**8:
        return head + struct.pack(">BB", 0xC4, size), image.data
    if size < 2**16:
        return head + struct.pack(">BH", 0xC5, size), image.data
    if size < 2**32:
        return head + struct.pack(">BI", 0xC6, size), image.data
    raise MessageError(f"Image: expected less than 4 GiB of data, got {size} bytes")


def decode(kind: type[M], data: bytes) -> M:
    """Decode one message of exactly this type and version.

    Raises:
        MessageError: naming the type and version that came instead, or the path of the
            field that does not fit.
    """
    try:
        message: M = _DECODERS[kind].decode(data)
        return message
    except (ValueError, RecursionError) as error:  # msgspec's own errors are ValueErrors
        wanted, got = f"{kind.__name__} v1", _announced(data)
        if got not in ("", wanted):
            raise MessageError(f"expected {wanted}, got {got} ({len(data)} bytes)") from None
        raise MessageError(f"{kind.__name__}: {_told(kind, error)} ({len(data)} bytes)") from None


def _told(kind: type[Message], error: Exception) -> str:
    """What msgspec says, with the field's name in the place of its number on the wire."""
    names = ("type", *kind.__struct_fields__)
    path = re.compile(r"`\$\[([0-9]+)\]")
    return path.sub(lambda found: f"`$.{names[int(found[1])]}", str(error))


def _announced(data: bytes) -> str:
    """The type and version that the first two elements name, "" where they cannot be read."""
    try:
        type_id, version = _HEAD.decode(data)[:2]
        numbers = (_UINT.decode(type_id), _UINT.decode(version))
    except (ValueError, RecursionError):
        return ""
    return f"{_NAMES.get(numbers[0], f'unknown type {numbers[0]}')} v{numbers[1]}"


def encoding_of(kind: type[Message]) -> str:
    """The Zenoh encoding announced for a type: tools read it, services read the bytes."""
    return f"application/msgpack;fairlead.{kind.__name__}.v1"
