"""The one check of what a policy puts out, in Python or behind a server."""

from __future__ import annotations

import numpy as np

from fairlead.errors import PolicyError, expected
from fairlead.policy import Actions


def policy_rows(actions: object, width: int, horizon: int) -> Actions:
    """What a policy returned, an array or rows of numbers, as `float_rows` has it.

    Raises:
        PolicyError: as `float_rows`.
        ValueError: rows of unequal length.
    """
    array = actions if isinstance(actions, np.ndarray) else np.asarray(actions)
    if isinstance(actions, list | tuple):
        array = next((row for row in actions if isinstance(row, np.ma.MaskedArray)), array)
    is_no_array = array.ndim == 0 and array.dtype == object  # None, a map
    return float_rows("policy", "actions", actions if is_no_array else array, width, horizon)


def float_rows(who: str, name: str, value: object, width: int, horizon: int) -> Actions:
    """An array as float32 ``[H, width]``, checked before anything compares it.

    Floats of any size are taken, since servers send what numpy computed, most often float64; they
    are rounded to the nearest float32 here and nowhere else. Discarded dimensions count too: a
    policy that says NaN anywhere is not in order.

    Args:
        horizon: most rows that the skill takes.

    Raises:
        PolicyError: for anything else than floats of that shape, finite as float32.
    """
    wanted = f"{name} as floats [1 to {horizon}, {width}]"
    if not isinstance(value, np.ndarray):
        raise PolicyError(expected(who, wanted, type(value).__name__))
    if isinstance(value, np.ma.MaskedArray):  # its masked numbers would come back to life
        raise PolicyError(expected(who, f"{name} without masked numbers", "a masked array"))
    fits = value.ndim == 2 and value.shape[1] == width and 1 <= len(value) <= horizon
    if value.dtype.kind != "f" or not fits:
        raise PolicyError(expected(who, wanted, f"{value.dtype} {list(value.shape)}"))
    with np.errstate(all="ignore"):  # what overflows is infinite, and refused
        rows = np.asarray(value, dtype="<f4")
    if not np.isfinite(rows).all():
        row, column = np.argwhere(~np.isfinite(rows))[0]
        got = f"{value[row, column]} in row {row} dimension {column}"
        raise PolicyError(expected(who, f"{name} as finite float32 numbers", got))
    return rows
