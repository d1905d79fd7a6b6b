"""What the gate did not let pass, in words, each said once."""

from __future__ import annotations

from fairlead.messages import Outcome, Verdict
from fairlead.wire.verdict_text import finding_text


class Refusals:
    """Which refusals are news: the same one, tick after tick, is said once."""

    def __init__(self) -> None:
        self._said = (0, "", "")
        self.newest = ""
        """The refusal that keeps the newest rows back; "" if they were released."""

    def news(self, verdict: Verdict) -> str:
        """What to tell the person of this verdict; "" if nothing, or nothing new."""
        if verdict.outcome == Outcome.RELEASED:
            self.newest = ""
            return ""
        self.newest = finding_text(verdict)
        about = (verdict.code, verdict.part, verdict.axis)
        if about == self._said:
            return ""
        self._said = about
        return self.newest

    def forget(self) -> None:
        """The person asks for something new: what was said may be said again."""
        self._said = (0, "", "")
