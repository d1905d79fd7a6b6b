"""Documents that both environments make alike from a number; numpy only."""

from __future__ import annotations

from typing import Any

import numpy as np

SEEDS = range(20)
DTYPES = ["<f4", "<f8", "<f2", "u1", "<i8", "?"]


def document(seed: int) -> dict[str, Any]:
    """Maps in maps with arrays of every kind and of up to five dimensions."""
    rng = np.random.default_rng(seed)
    made: dict[str, Any] = {"prompt": "put it thére", "count": seed, "nested": {}}
    for index in range(int(rng.integers(1, 6))):
        shape = rng.integers(0, 4, int(rng.integers(1, 6)))
        dtype = DTYPES[int(rng.integers(len(DTYPES)))]
        array = rng.integers(0, 100, shape).astype(dtype)
        made["nested"][f"array {index}"] = array
    made["list"] = [made["nested"]["array 0"], "text", 1.5]
    return made


def same(one: object, two: object) -> bool:
    """Equal, arrays bit by bit and by type; lists and tuples are alike."""
    if isinstance(one, np.ndarray) or isinstance(two, np.ndarray):
        return (
            isinstance(one, np.ndarray)
            and isinstance(two, np.ndarray)
            and (one.dtype, one.shape, one.tobytes()) == (two.dtype, two.shape, two.tobytes())
        )
    if isinstance(one, dict) and isinstance(two, dict):
        return one.keys() == two.keys() and all(same(one[key], two[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(two, list | tuple):
        return len(one) == len(two) and all(map(same, one, two))
    return one == two
