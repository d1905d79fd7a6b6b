"""openpi's messages: msgpack, arrays as maps with byte-string keys.

An array is ``{b"__ndarray__": True, b"data": raw bytes, b"dtype": "<f4", b"shape": [..]}``
in C order, a numpy number ``{b"__npgeneric__": True, b"data": number, b"dtype": ".."}``.
"""

from __future__ import annotations

from operator import index

import msgspec
import numpy as np

_KINDS = "biuf"


def encode(document: object) -> bytes:
    """Msgpack of anything made of maps, lists, strings, numbers and arrays."""
    return msgspec.msgpack.encode(document, enc_hook=_array_map)


def decode(data: bytes) -> object:
    """The document, its arrays rebuilt.

    Raises:
        ValueError, TypeError, RecursionError, MemoryError: for bytes that are no such document.
    """
    return _rebuilt(msgspec.msgpack.decode(data))


def _array_map(value: object) -> object:
    if isinstance(value, np.ndarray):
        return {
            b"__ndarray__": True,
            b"data": value.tobytes(),
            b"dtype": value.dtype.str,
            b"shape": list(value.shape),
        }
    raise TypeError(f"openpi message: expected an array, got {type(value).__name__}")


def _rebuilt(value: object) -> object:
    if isinstance(value, list):
        return [_rebuilt(item) for item in value]
    if not isinstance(value, dict):
        return value
    if b"__ndarray__" in value:
        return _array(value)
    if b"__npgeneric__" in value:
        return value.get(b"data")
    return {key: _rebuilt(item) for key, item in value.items()}


def _array(fields: dict[object, object]) -> np.ndarray[tuple[int, ...], np.dtype[np.generic]]:
    data, name, shape = (fields.get(key) for key in (b"data", b"dtype", b"shape"))
    if not isinstance(data, bytes) or not isinstance(name, str) or not isinstance(shape, list):
        raise ValueError("an array without data, dtype or shape")
    try:
        dtype = np.dtype(name)
    except TypeError as error:
        raise ValueError(str(error)) from None
    if dtype.kind not in _KINDS:
        raise ValueError(f"an array of {name}")
    return np.frombuffer(data, dtype).reshape([index(size) for size in shape])
