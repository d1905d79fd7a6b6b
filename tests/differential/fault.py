"""Why a chunk was not released, or not all of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """The evidence of one check. value, limit and margin in the unit of the axis.

    margin: "limit minus value" (`fairlead.messages.Verdict`); for a lower limit value minus
    limit, so that it is negative outside; 0 where the rule has no measure.
    """

    code: int
    row: int
    part: str
    axis: str
    value: float = 0.0
    limit: float = 0.0
    margin: float = 0.0
    source: str = ""


def above(
    code: int, row: int, where: tuple[str, str], value: float, limit: float, source: str
) -> Fault:
    """``value`` should not exceed ``limit``. where: part and axis."""
    return Fault(code, row, *where, value, limit, limit - value, source)


def below(
    code: int, row: int, where: tuple[str, str], value: float, limit: float, source: str
) -> Fault:
    """``value`` should not fall short of ``limit``. where: part and axis."""
    return Fault(code, row, *where, value, limit, value - limit, source)
