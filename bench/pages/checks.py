"""The table of docs/safety-checks.md, made of the checks that Python knows."""

from __future__ import annotations

from fairlead.paths import repo_root
from fairlead.wire.gate_checks import CHECKS, GateCheck

PAGE = repo_root() / "docs" / "safety-checks.md"
START, END = "<!-- checks: python -m bench.pages --write -->\n", "<!-- end of checks -->"
HEAD = ("check: hazard", "what passes", "else")


def table() -> str:
    """A row for each check, in Markdown."""
    rows = [HEAD, ("---",) * len(HEAD), *(_row(code, check) for code, check in CHECKS.items())]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def current_page() -> str:
    """The page as it has to be now.

    Raises:
        ValueError: it has no marks for the table.
    """
    before, found, rest = PAGE.read_text().partition(START)
    _, ended, after = rest.partition(END)
    if not found or not ended:
        raise ValueError(f"pages: {PAGE} has no marks {START.strip()} and {END}")
    return f"{before}{START}{table()}{END}{after}"


def _row(code: int, check: GateCheck) -> tuple[str, ...]:
    name = f"G{code:03d}"
    anchor = check.section.lower().translate(str.maketrans(" ", "-", ":,"))
    link = f"[{name}](#{anchor})" if anchor else name
    return (
        f"{link}: {_plain(check.hazard)}",
        _plain(check.rule),
        check.outcome,
    )


def _plain(text: str) -> str:
    return text.replace("|", "\\|")
