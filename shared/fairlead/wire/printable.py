"""Text from outside that cannot end a line, move a cursor or turn around what is read."""

from __future__ import annotations

import logging
import re

from fairlead.log_stamp import utc_stamp

_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def printable(text: str) -> str:
    r"""Control characters as the gate writes them: each byte of their UTF-8 as ``\xNN``.

    >>> printable("hand\nINFO safety: armed")
    'hand\\x0aINFO safety: armed'
    """
    return _CONTROL.sub(lambda found: "".join(f"\\x{b:02x}" for b in found[0].encode()), text)


def printable_lines(text: str) -> str:
    """Likewise, but lines end where they did, and a tab is blanks."""
    return "\n".join(printable(line) for line in text.expandtabs().split("\n"))


class LineFormatter(logging.Formatter):
    """``<UTC> LEVEL name: message`` in one line, whoever wrote it; a traceback keeps its own."""

    def __init__(self) -> None:
        super().__init__("%(levelname)s %(name)s: %(message)s")

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 (the library's name)
        """The line without the traceback."""
        record.message = printable(record.message)
        return f"{utc_stamp(record.created)} {super().formatMessage(record)}"
