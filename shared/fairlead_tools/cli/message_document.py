"""A message as people read it: blocks as numbers, ids and hashes in hex, codes by name."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any

import msgspec

from fairlead.messages import Decision, GateState, Hold, Message, Outcome, floats
from fairlead.modes import ControlMode

_IDS = frozenset(
    ("session", "epoch", "claim_id", "verdict_id", "latch_id", "stop_id", "goal_id", "stop_ids")
)
_NAMED: dict[str, type[IntEnum]] = {
    "hold": Hold,
    "mode": ControlMode,
    "decision": Decision,
    "outcome": Outcome,
    "state": GateState,
}
# A picture's bytes are no numbers to read.
_OPAQUE = frozenset(("data",))
_HEX = frozenset(("robot_hash", "config_hash", "skill_hash", "trace"))


def message_document(message: Message) -> dict[str, Any]:
    """One message as plain JSON values, fields in wire order, without its version.

    Blocks of float64 become lists of numbers; a picture's bytes only their count.
    """
    return _struct(message)


def _struct(value: msgspec.Struct) -> dict[str, Any]:
    names = (field.name for field in msgspec.structs.fields(value))
    return {name: _field(name, getattr(value, name)) for name in names if name != "version"}


def _field(name: str, value: object) -> Any:
    if isinstance(value, msgspec.Struct):
        return _struct(value)
    if isinstance(value, bytes):
        return _block(name, value)
    if isinstance(value, tuple):
        return [_field(name, item) for item in value]
    if isinstance(value, int) and not isinstance(value, bool):
        return _number(name, value)
    return value


def _block(name: str, value: bytes) -> Any:
    if name in _OPAQUE:
        return f"{len(value)} bytes"
    return value.hex() if name in _HEX else floats(value).tolist()


def _number(name: str, value: int) -> Any:
    if name in _IDS:
        return f"{value:016x}" if value else "none"
    if name == "code":
        return f"G{value:03}" if value else "none"
    return _name_of(_NAMED[name], value) if name in _NAMED else value


def _name_of(kind: Callable[[int], IntEnum], value: int) -> str | int:
    try:
        return kind(value).name.lower()
    except ValueError:
        return value  # a newer sender's code: shown as it came
