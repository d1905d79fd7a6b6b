"""Messages of RLDX and GR00T servers: msgpack, and in it arrays of one of two kinds.

``npy``: a ``.npy`` file, ``{"__ndarray_class__": True, "as_npy": bytes}``.
``nd``: ``{b"nd": True, b"type": "<f4", b"kind": b"", b"shape": [..], b"data": raw bytes}`` in C
order, as the package msgpack-numpy writes it; a number has ``b"nd": False`` and no shape.

Both are read. Pickled objects, which either could carry, are refused.
"""

from __future__ import annotations

import io
from operator import index
from tokenize import TokenError
from typing import Literal

import msgspec
import numpy as np

Arrays = Literal["npy", "nd"]

_KINDS = "biuf"


def encode(document: object, arrays: Arrays = "npy") -> bytes:
    """Msgpack of anything made of maps, lists, strings, numbers and arrays."""
    return msgspec.msgpack.encode(document, enc_hook=_npy_map if arrays == "npy" else _nd_map)


def decode(data: bytes) -> object:
    """The document, its arrays rebuilt.

    Raises:
        ValueError, TypeError, RecursionError, MemoryError: for bytes that are no such document.
    """
    return _rebuilt(msgspec.msgpack.decode(data))


def _npy_map(value: object) -> object:
    file = io.BytesIO()
    np.save(file, _array_of(value), allow_pickle=False)
    return {"__ndarray_class__": True, "as_npy": file.getvalue()}


def _nd_map(value: object) -> object:
    array = _array_of(value)
    return {
        b"nd": True,
        b"type": array.dtype.str,
        b"kind": b"",
        b"shape": list(array.shape),
        b"data": array.tobytes(),
    }


def _array_of(value: object) -> np.ndarray[tuple[int, ...], np.dtype[np.generic]]:
    if isinstance(value, np.ndarray):
        return value
    raise TypeError(f"rldx message: expected an array, got {type(value).__name__}")


def _rebuilt(value: object) -> object:
    if isinstance(value, list):
        return [_rebuilt(item) for item in value]
    if not isinstance(value, dict):
        return value
    if "__ndarray_class__" in value:
        return _from_npy(value.get("as_npy"))
    if b"nd" in value:
        return _from_nd(value)
    return {key: _rebuilt(item) for key, item in value.items()}


def _from_npy(data: object) -> object:
    if not isinstance(data, bytes):
        raise ValueError("an array without its bytes")
    try:
        return np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
    except TokenError as error:  # of a header that is no Python
        raise ValueError(f"an array whose header is none: {error}") from None


def _from_nd(fields: dict[object, object]) -> object:
    name, data, shape = (fields.get(key) for key in (b"type", b"data", b"shape"))
    if not isinstance(name, str) or not isinstance(data, bytes):
        raise ValueError("an array without its type or data")
    dtype = np.dtype(name)
    if dtype.kind not in _KINDS:
        raise ValueError(f"an array of {name}")
    values = np.frombuffer(data, dtype)
    if fields[b"nd"] is not True:
        return values.reshape(())[()]
    if not isinstance(shape, list):
        raise ValueError("an array without its shape")
    return values.reshape([index(size) for size in shape])
