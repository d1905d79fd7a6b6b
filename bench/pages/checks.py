"""The list of docs/safety-checks.md, made of the checks that Python knows."""

from __future__ import annotations

import re
import textwrap

from fairlead.paths import repo_root
from fairlead.wire.gate_checks import CHECKS, GateCheck

PAGE = repo_root() / "docs" / "safety-checks.md"
START, END = "<!-- checks: python -m bench.pages --write -->\n", "<!-- end of checks -->"
WIDTH = 120


def listed() -> str:
    """An item for each check, in Markdown."""
    return "".join(_item(code, check) for code, check in CHECKS.items())


def current_page() -> str:
    """The page as it has to be now.

    Raises:
        ValueError: it has no marks for the list.
    """
    before, found, rest = PAGE.read_text().partition(START)
    _, ended, after = rest.partition(END)
    if not found or not ended:
        raise ValueError(f"pages: {PAGE} has no marks {START.strip()} and {END}")
    return f"{before}{START}{listed()}{END}{after}"


def _item(code: int, check: GateCheck) -> str:
    name = f"G{code:03d}"
    anchor = check.section.lower().translate(str.maketrans(" ", "-", ":,"))
    link = f"[{name}](#{anchor})" if anchor else name
    outcome = f"{check.outcome[0].upper()}{check.outcome[1:]}"
    text = f"- **{link}, {check.hazard}**: {check.rule}. *{outcome}.*"
    # No line begins with an operator: Markdown would take it for a list's item or a quotation.
    bound = re.sub(r" (?=[-+<>=/]+ )", "\0", text)
    wrapped = textwrap.fill(
        bound, WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
    )
    return wrapped.replace("\0", " ") + "\n"
