"""What the gate says in words: its verdicts, and why it is not armed."""

from __future__ import annotations

from fairlead.messages import GateState, GateStatus, Outcome, Verdict
from fairlead.wire.gate_checks import CHECKS


def check_title(code: int) -> str:
    """What a check is about; "check" for one that this release does not know."""
    return CHECKS[code].title if code in CHECKS else "check"


def describe(verdict: Verdict) -> str:
    """One line: code, check, where, value and limit; ``fairlead why`` says where that is from.

    >>> # "G020 limit: chunk 3 refused at row 2, arm x: value 5, limit 0.0867"
    """
    what = check_title(verdict.code)
    verb = "refused" if verdict.outcome == Outcome.REFUSED else "truncated"
    where = f" at row {verdict.row}" if verdict.row >= 0 else ""
    axis = f", {verdict.part} {verdict.axis}".rstrip() if verdict.part else ""
    return f"G{verdict.code:03d} {what}: chunk {verdict.seq} {verb}{where}{axis}{_why(verdict)}"


def why_not_armed(gate: GateStatus) -> str:
    """Why the gate is not armed and what would change it; "" if it is armed."""
    if gate.state == GateState.ARMED:
        return ""
    return gate.cause + (f"; try: {gate.fix}" if gate.cause and gate.fix else "")


def _why(verdict: Verdict) -> str:
    """The numbers, or for a rule that has none what it asks for."""
    if verdict.value == 0.0 and verdict.limit == 0.0:
        return f": needs {verdict.limit_source}" if verdict.limit_source else ""
    value, limit = f"{verdict.value:g}", f"{verdict.limit:g}"
    if value == limit and verdict.value != verdict.limit:  # apart by less than six digits show
        value, limit = repr(verdict.value), repr(verdict.limit)
    return f": value {value}, limit {limit}"
