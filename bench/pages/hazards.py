"""The table of hazards in docs/safety.md: checks that answer them, tests that prove the checks."""

from __future__ import annotations

import re

from bench.pages.hazard_sources import asked_codes, core_tests
from fairlead.paths import repo_root
from fairlead.wire.gate_checks import CHECKS

PAGE = repo_root() / "docs" / "safety.md"
BEGIN = "<!-- hazards: written by `python -m bench.pages --write` -->"
END = "<!-- end of hazards -->"


def table() -> str:
    """One row per check that the core asks, with the tests found for it, in Markdown."""
    lines = ["| code | hazard | what to do | tests |", "|---|---|---|---|"]
    tests, asked = core_tests(), asked_codes()
    for code, check in CHECKS.items():
        if code in asked:
            proof = _proof([test.file for test in tests if code in test.codes])
            lines.append(f"| G{code:03d} | {check.hazard} | {check.hint} | {proof} |")
    return "\n".join(lines)


def _proof(files: list[str]) -> str:
    """The files with tests that name the code: the first three, by their names."""
    named = [name.removesuffix(".cpp") for name in sorted(set(files))]
    return ", ".join(named[:3]) + (", ..." if len(named) > 3 else "") if named else "none"


def current_page() -> str:
    """The page with the table as it has to be now."""
    text = PAGE.read_text()
    between = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END), re.S)
    if between.search(text) is None:
        raise SystemExit(f"hazards: {PAGE} lacks the marks {BEGIN!r} and {END!r}")
    return between.sub(lambda _: f"{BEGIN}\n\n{table()}\n\n{END}", text)
