"""The gate's verdicts in words, for people who read the feedback."""

from __future__ import annotations

from fairlead.messages import Outcome, Verdict

CHECKS = {
    1: "not a well-formed chunk",
    2: "other HAL session or robot",
    3: "old arm epoch",
    4: "no such claim, or parts it does not cover",
    5: "sequence number not increasing",
    6: "observation too new or too old",
    7: "horizon or width",
    8: "number not finite or too large",
    9: "mode, mask or padding",
    10: "too many chunks",
    11: "measured state",
    12: "every row is past",
    13: "measured jump",
    20: "limit",
    21: "does not start where the robot is",
    22: "jump between rows",
    23: "does not continue the released rows",
    24: "cannot brake before a limit",
    25: "mode switch not allowed",
    26: "a joint too fast for what the tool is told",
    30: "nobody can say where it leads",
    31: "outside the workspace",
    32: "too near to itself",
    33: "too near to a singular pose",
    34: "base outside its zones",
    40: "the robot does not do what was released",
    41: "a sensor that does not change",
    42: "contact, or an object lost",
    43: "did not stop in time",
    50: "the gate itself: too slow, or changed in memory",
}
"""What each check of the gate is about, by number."""


def describe(verdict: Verdict, *, with_source: bool = True) -> str:
    """One line: code, check, where, value, limit and, if wanted, where the limit is from.

    >>> # "G020 limit: chunk 3 refused at row 2, arm x: value 5 beyond 0.0867 (robot.yaml)"
    """
    what = CHECKS.get(verdict.code, "check")
    verb = "refused" if verdict.outcome == Outcome.REFUSED else "truncated"
    where = f" at row {verdict.row}" if verdict.row >= 0 else ""
    axis = f", {verdict.part} {verdict.axis}".rstrip() if verdict.part else ""
    return (
        f"G{verdict.code:03d} {what}: chunk {verdict.seq} {verb}{where}{axis}"
        f"{_why(verdict, with_source=with_source)}"
    )


def _why(verdict: Verdict, *, with_source: bool) -> str:
    """The numbers, or for a rule that has none what it asks for."""
    if verdict.value == 0.0 and verdict.limit == 0.0:
        return f": needs {verdict.limit_source}" if verdict.limit_source else ""
    source = f" ({verdict.limit_source})" if verdict.limit_source and with_source else ""
    value, limit = f"{verdict.value:g}", f"{verdict.limit:g}"
    if value == limit and verdict.value != verdict.limit:  # apart by less than six digits show
        value, limit = repr(verdict.value), repr(verdict.limit)
    return f": value {value}, limit {limit}{source}"
