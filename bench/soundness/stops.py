"""Why the gate stopped, in words that can be counted and read."""

from __future__ import annotations

import re

_NUMBERS = re.compile(r"(?:stopped: )?(G\d{3} [^:]+): ([^ ,]+)[^,]*, limit ([^ ,]+)")
WIDE = 60
"""Letters kept of a cause without numbers."""


def kind_of(cause: str) -> str:
    """Code, part and joint or axis: what stops are counted by."""
    found = _NUMBERS.match(cause)
    return found[1] if found else cause[:WIDE]


def story_of(cause: str) -> str:
    """The same with its value and limit, rounded."""
    found = _NUMBERS.match(cause)
    if not found:
        return cause[:WIDE]
    return f"{found[1]} {float(found[2]):.3g}, limit {float(found[3]):.3g}"
