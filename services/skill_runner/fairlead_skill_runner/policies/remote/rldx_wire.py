"""Messages of RLDX and GR00T servers: msgpack, arrays as ``.npy`` files in it.

An array is ``{"__ndarray_class__": True, "as_npy": bytes}``.
"""

from __future__ import annotations

import io

import msgspec
import numpy as np


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
        file = io.BytesIO()
        np.save(file, value, allow_pickle=False)
        return {"__ndarray_class__": True, "as_npy": file.getvalue()}
    raise TypeError(f"rldx message: expected an array, got {type(value).__name__}")


def _rebuilt(value: object) -> object:
    if isinstance(value, list):
        return [_rebuilt(item) for item in value]
    if not isinstance(value, dict):
        return value
    if "__ndarray_class__" in value:
        return _array(value.get("as_npy"))
    return {key: _rebuilt(item) for key, item in value.items()}


def _array(data: object) -> object:
    if not isinstance(data, bytes):
        raise ValueError("an array without its bytes")
    try:
        return np.load(io.BytesIO(data), allow_pickle=False)
    except EOFError:
        raise ValueError("an array without its bytes") from None
