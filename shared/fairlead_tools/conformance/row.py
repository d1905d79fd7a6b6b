"""What one check expected of a HAL and what came."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from fairlead.errors import FairleadError

GROUPS = (
    "joints", "grippers", "tools", "base", "forged rows", "forged leases", "limits", "pause",
)  # fmt: skip
"""What may be left out: not that motion begins and ends as it has to."""

Outcome = Literal["pass", "fail", "not checked"]


@dataclass(frozen=True)
class Row:
    """A line of the table.

    of: which part and mode, "" for the whole robot. expected: with its bound. source: where the
    bound is declared. got: what was measured; of what was not checked, why not.
    """

    check: str
    of: str
    expected: str
    source: str
    got: str
    outcome: Outcome
    fix: str = ""


@dataclass(frozen=True)
class Check:
    """What is the same in every outcome of one check."""

    name: str
    expected: str
    source: str
    fix: str
    of: str = ""

    def row(self, problems: Sequence[str], got: str) -> Row:
        """Passed if there is no problem; ``got`` is what to say then."""
        if problems:
            shown = "; ".join(problems[:MOST_SHOWN])
            more = len(problems) - MOST_SHOWN
            text = shown + (f"; and {more} more" if more > 0 else "")
            return Row(self.name, self.of, self.expected, self.source, text, "fail", self.fix)
        return Row(self.name, self.of, self.expected, self.source, got, "pass")

    def not_checked(self, why: str) -> Row:
        """It could not be made."""
        return Row(self.name, self.of, self.expected, self.source, why, "not checked")


MOST_SHOWN = 3


class SilentHalError(FairleadError):
    """The HAL publishes no joint state that could be read any more, or goes no further."""
