"""Differences between reference and gate that are known, harmless and reported.

A test shows each of them: one that has gone must leave this list.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tests.differential.case import Case
from tests.differential.comparison import Difference

ROWS_NEAR_THE_END = 128


@dataclass(frozen=True)
class Known:
    """why: what the gate does instead, and why nothing is released that should not be."""

    name: str
    why: str
    covers: Callable[[Case, list[Difference]], bool]


def _is_at_the_end_of_time(case: Case, found: list[Difference]) -> bool:
    chunks = (case.chunk, case.earlier or case.chunk)
    return _gate_says(found, "axis", "start_tick") and any(
        2**64 - chunk.start_tick <= ROWS_NEAR_THE_END for chunk in chunks
    )


def _gate_says(found: list[Difference], field: str, value: object) -> bool:
    return any((difference.field, difference.got) == (field, value) for difference in found)


def _is_only_the_margin(_: Case, found: list[Difference]) -> bool:
    return all(d.field == "margin" and d.expected == -float(str(d.got)) for d in found)


def _commands_the_least_of_all_velocities(case: Case, found: list[Difference]) -> bool:
    chunks = (case.chunk, case.earlier or case.chunk)
    return _gate_says(found, "code", 11) and any(
        abs(value) == 5e-324 for c in chunks for p in c.parts for value in p.values.flat
    )


KNOWN = (
    Known(
        "the last 128 ticks of 64 bits",
        "G007 refuses chunks that start there, also where all their rows fit",
        _is_at_the_end_of_time,
    ),
    Known(
        "the margin of a breached lower bound",
        "G011 gives limit minus value there, so that its margin is positive outside",
        _is_only_the_margin,
    ),
    Known(
        "the smallest number there is",
        "G011 does not take a velocity of 5e-324 for one that leads back",
        _commands_the_least_of_all_velocities,
    ),
)


def is_known(case: Case, found: list[Difference]) -> bool:
    return any(known.covers(case, found) for known in KNOWN)
