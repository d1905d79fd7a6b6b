"""The wire's own words for the types of `fairlead.messages`, as docs/wire-format.md uses them."""

from __future__ import annotations

from typing import Any

from msgspec import inspect

_UINTS = {255: "uint8", 2**32 - 1: "uint32", None: "uint64"}


def rows(kind: type[Any]) -> list[tuple[str, str]]:
    """Field name and wire type of one message or record, in wire order.

    A message starts with its type id and version, a record with its first field.
    """
    info = inspect.type_info(kind)
    assert isinstance(info, inspect.StructType)
    head = [("type", str(info.tag))] if info.tag is not None else []
    return head + [(field.name, wire_name(field.type)) for field in info.fields]


def wire_name(kind: inspect.Type) -> str:
    """For example ``uint64``, ``bin 32``, ``[Acted]``, ``"rgb8" or "jpeg"``, ``bin or nil``."""
    match kind:
        case inspect.IntType(ge=0, le=high):
            return _UINTS[high]
        case inspect.BytesType(min_length=size, max_length=most):
            return f"bin {size}" if size is not None and size == most else "bin"
        case inspect.LiteralType(values=words):
            return " or ".join(f'"{w}"' if isinstance(w, str) else str(w) for w in words)
        case inspect.UnionType(types=types):
            return " or ".join(sorted(map(wire_name, types), key=lambda name: name == "nil"))
        case inspect.VarTupleType(item_type=item):
            return f"[{wire_name(item)}]"
        case inspect.TupleType(item_types=items):
            return f"({', '.join(map(wire_name, items))})"
        case inspect.StructType(cls=cls):
            return cls.__name__
    return _PLAIN[type(kind)]


_PLAIN = {
    inspect.IntType: "int",
    inspect.FloatType: "float64",
    inspect.BoolType: "bool",
    inspect.StrType: "str",
    inspect.NoneType: "nil",
}
