"""Hypothesis strategies for every message type, derived from the types themselves."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st
from msgspec import inspect

from fairlead.messages import LayoutFault, LayoutState, Message

I64_MIN, U64_MAX = -(2**63), 2**64 - 1


def messages(kind: type[Message]) -> st.SearchStrategy[Message]:
    """Any message of one type that its decoder must accept."""
    fields = _fields(kind)
    if kind is LayoutState:
        fault = _of(inspect.type_info(LayoutFault))
        with_values = st.builds(LayoutState, **{**fields, "values": st.binary(), "fault": _NONE})
        with_fault = st.builds(LayoutState, **{**fields, "values": _NONE, "fault": fault})
        return st.one_of(with_values, with_fault)
    return st.builds(kind, **fields)


_NONE: st.SearchStrategy[None] = st.none()


def _fields(kind: type[Any]) -> dict[str, st.SearchStrategy[Any]]:
    info = inspect.type_info(kind)
    assert isinstance(info, inspect.StructType)
    return {field.name: _of(field.type) for field in info.fields}


def _of(kind: inspect.Type) -> st.SearchStrategy[Any]:
    match kind:
        case inspect.IntType(ge=low, le=high):
            return st.integers(I64_MIN if low is None else low, U64_MAX if high is None else high)
        case inspect.FloatType():
            return st.floats()
        case inspect.BoolType():
            return st.booleans()
        case inspect.StrType():
            return st.text(max_size=40)
        case (
            inspect.BytesType(min_length=shortest, max_length=longest)
            | inspect.MemoryViewType(min_length=shortest, max_length=longest)
        ):
            return st.binary(min_size=shortest or 0, max_size=longest or 300)
        case inspect.LiteralType(values=values):
            return st.sampled_from(values)
        case inspect.NoneType():
            return _NONE
        case inspect.UnionType(types=types):
            return st.one_of(*(_of(one) for one in types))
        case inspect.VarTupleType(item_type=item):
            return st.lists(_of(item), max_size=18).map(tuple)
        case inspect.TupleType(item_types=items):
            return st.tuples(*(_of(item) for item in items))
        case inspect.StructType(cls=cls):
            return st.builds(cls, **_fields(cls))
    raise AssertionError(f"no strategy for {kind}: extend this file")
