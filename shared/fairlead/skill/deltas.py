"""Which moments of the past a policy sees."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator

MOST_ROWS = 64
"""Of the past."""


def _end_now(value: tuple[int, ...]) -> tuple[int, ...]:
    if (
        not value
        or value[-1] != 0
        or list(value) != sorted(set(value))
        or value[0] < -MOST_ROWS
    ):  # fmt: skip
        raise ValueError(
            f"expected ascending whole numbers from -{MOST_ROWS} that end with 0, got {list(value)}"
        )
    return value


Deltas = Annotated[tuple[int, ...], AfterValidator(_end_now)]
"""In rows of the policy before the newest, which is 0; ascending."""

NOW = (0,)
