"""What the gate says in words: its verdicts, and why it is not armed."""

from __future__ import annotations

from typing import Protocol

from fairlead.messages import GateState, GateStatus, Outcome, Verdict
from fairlead.modes import ControlMode
from fairlead.wire.gate_checks import CHECKS

_CHANGE = 25


class Finding(Protocol):
    """What a check found, as in ``fairlead.messages.Verdict``; a log may spell a number."""

    @property
    def code(self) -> int:
        """Of the check."""

    @property
    def part(self) -> str:
        """At fault, or empty."""

    @property
    def axis(self) -> str:
        """Its joint or axis, or empty."""

    @property
    def value(self) -> float | str:
        """What was found."""

    @property
    def limit(self) -> float | str:
        """What is allowed."""

    @property
    def margin(self) -> float | str:
        """Between both."""

    @property
    def limit_source(self) -> str:
        """Where the limit is from, or what the rule needs."""

    @property
    def unit(self) -> str:
        """Of the numbers; empty: a rule."""


def check_title(code: int) -> str:
    """What a check is about; "check" for one that this release does not know."""
    return CHECKS[code].title if code in CHECKS else "check"


def is_rule(found: Finding) -> bool:
    """Whether it broke a rule, which ``limit_source`` words, and not a limit of a magnitude.

    A magnitude has a unit; in the log of an older gate it has a margin.
    """
    return not found.unit and found.margin == 0.0


def with_unit(number: float | str, unit: str) -> str:
    """A number in six digits, with its unit if it has one.

    >>> with_unit(0.0867, "m"), with_unit(7.0, "1")
    ('0.0867 m', '7')
    """
    text = number if isinstance(number, str) else f"{number:g}"
    return text if unit in ("", "1") else f"{text} {unit}"


def place_of(found: Finding) -> str:
    """Part and axis, and which control mode was to follow which; "" if it names none."""
    words = [found.part, found.axis]
    numbers = (found.value, found.limit)
    if found.code == _CHANGE and found.axis == "mode" and numbers[0] != numbers[1]:
        now, last = (ControlMode(int(number)).yaml_name for number in numbers)
        words.append(f"{now} after {last}")
    return " ".join(word for word in words if word)


def told_apart(one: float | str, other: float | str, digits: int = 6) -> tuple[str, str]:
    """Both in so many digits, and in all they have where so many are the same.

    >>> told_apart(0.09, 0.0867), told_apart(0.08670000000000001, 0.0867)
    (('0.09', '0.0867'), ('0.08670000000000001', '0.0867'))
    """
    first, second = (x if isinstance(x, str) else f"{x:.{digits}g}" for x in (one, other))
    return (repr(one), repr(other)) if first == second and one != other else (first, second)


def value_and_limit(found: Finding) -> tuple[str, str]:
    """Both with their unit."""
    value, limit = told_apart(found.value, found.limit)
    return with_unit(value, found.unit), with_unit(limit, found.unit)


def numbers_of(found: Finding) -> str:
    """Value and limit with their unit; of a rule what it needs.

    Where a limit is from may be a page of text: ``fairlead why`` has it.
    """
    if is_rule(found):
        return f"needs {found.limit_source}" if found.limit_source else ""
    value, limit = value_and_limit(found)
    return f"{value}, limit {limit}"


def example_text(code: int) -> str:
    """What a check may find, in the words of a refusal."""
    example = CHECKS[code].example
    return ": ".join(text for text in (place_of(example), numbers_of(example)) if text)


def finding_text(found: Finding) -> str:
    """Check, place and numbers, without the chunk.

    >>> # "G020 limit: arm x: 5 m, limit 0.0867 m"
    """
    what = f"G{found.code:03d} {check_title(found.code)}"
    return ": ".join(text for text in (what, place_of(found), numbers_of(found)) if text)


def describe(verdict: Verdict) -> str:
    """One line of at most 160 characters: code, check, chunk, place and numbers.

    >>> # "G020 limit: chunk 3 refused at row 2, arm x: 5 m, limit 0.0867 m"
    """
    verb = "refused" if verdict.outcome == Outcome.REFUSED else "truncated"
    row = f" at row {verdict.row}" if verdict.row >= 0 else ""
    where = ", ".join(
        text for text in (f"chunk {verdict.seq} {verb}{row}", place_of(verdict)) if text
    )
    what = f"G{verdict.code:03d} {check_title(verdict.code)}"
    return ": ".join(text for text in (what, where, numbers_of(verdict)) if text)


def why_not_armed(gate: GateStatus) -> str:
    """Why the gate is not armed and what would change it; "" if it is armed."""
    if gate.state == GateState.ARMED:
        return ""
    return gate.cause + (f"; try: {gate.fix}" if gate.cause and gate.fix else "")
