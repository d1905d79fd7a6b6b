"""Blocks of numbers as they travel: little-endian float64, row-major."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fairlead.errors import MessageError

FloatArray = npt.NDArray[np.float64]


def pack_floats(values: npt.ArrayLike) -> bytes:
    """Encode numbers as the wire's little-endian float64 block, row-major."""
    return np.ascontiguousarray(values, dtype="<f8").tobytes()


def floats(block: bytes, width: int | None = None) -> FloatArray:
    """Decode a float64 block: shape ``[n]``, or ``[rows, width]`` where width is given.

    Raises:
        MessageError: if the block is not a whole number of float64 (or of rows).
    """
    row = 8 * (width or 1)
    if row <= 0 or len(block) % row:
        raise MessageError(f"float block: expected a multiple of {row} bytes, got {len(block)}")
    array = np.frombuffer(block, dtype="<f8")
    return array if width is None else array.reshape(-1, width)
