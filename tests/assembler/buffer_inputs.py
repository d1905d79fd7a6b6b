"""A transform buffer, messages for it, and what a lookup in it complains about."""

from __future__ import annotations

import pytest

from fairlead.errors import LayoutError
from fairlead.messages import Transform, TransformBatch, pack_floats
from fairlead_state_assembler import TransformBuffer

SESSION = 7


def buffer_with(**max_age: int) -> TransformBuffer:
    buffer = TransformBuffer(max_age)
    assert buffer.enter(SESSION, 1)
    return buffer


def batch(tick: int, *links: tuple[str, str, float], **changed: object) -> TransformBatch:
    transforms = tuple(
        Transform(
            parent=parent,
            child=child,
            translation=pack_floats([x, 0.0, 0.0]),
            rotation_xyzw=pack_floats([0.0, 0.0, 0.0, 1.0]),
        )
        for parent, child, x in links
    )
    fields: dict[str, object] = {
        "session": SESSION,
        "tick": tick,
        "is_static": False,
        "transforms": transforms,
    }
    return TransformBatch(**{**fields, **changed})  # type: ignore[arg-type]


def error_of(buffer: TransformBuffer, parent: str, child: str, tick: int) -> LayoutError:
    with pytest.raises(LayoutError) as error:
        buffer.lookup(parent, child, tick)
    return error.value
