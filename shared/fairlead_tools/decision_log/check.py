"""One check of the gate in words: what it asks, what follows, what to do, how to test it."""

from __future__ import annotations

from fairlead.wire.gate_checks import CHECKS
from fairlead.wire.verdict_text import example_text

TESTS = "build/safety/fairlead-safety-tests --test-case='*{}*'"
PAGE = "docs/safety-checks.md"


def check_lines(code: int) -> list[str]:
    """The check's row of the table in docs/safety-checks.md, and what to do about it."""
    check, name = CHECKS[code], f"G{code:03d}"
    said = {
        "hazard": check.hazard,
        "passes": check.rule,
        "unit": ", ".join("a plain number" if unit == "1" else unit for unit in check.units),
        "else": check.outcome,
        "example": example_text(code),
        "do": check.hint,
        "more": f"{PAGE}, {check.section}" if check.section else PAGE,
        "tests": TESTS.format(name),
    }
    return [f"{name} {check.title}", *(f"  {key:<7} {text}" for key, text in said.items() if text)]
