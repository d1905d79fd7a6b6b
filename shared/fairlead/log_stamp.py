"""What a line of a log begins with: the time in UTC, then the level."""

from __future__ import annotations

import re
import time
from datetime import UTC, datetime

_STAMPED = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z ")
STAMP_LENGTH = len("2026-11-23T07:54:00.123Z")
_LEVELS = ("DEBUG ", "INFO ", "WARNING ", "ERROR ", "CRITICAL ")


def utc_stamp(time_s: float) -> str:
    """Seconds since 1970 as ``2026-11-23T07:54:00.123Z``."""
    moment = datetime.fromtimestamp(time_s, UTC).isoformat(timespec="milliseconds")
    return moment.replace("+00:00", "Z")


def stamped(line: str, name: str) -> str:
    """``line`` with time, level and the service's name, where it came without.

    Services write ``<time> <level> <name>: <text>`` themselves. What a library or a crash prints
    gets the time it came and the level ``PRINT``.
    """
    if _STAMPED.match(line):
        return line
    text = line if line.startswith(_LEVELS) else f"PRINT {name}: {line}"
    return f"{utc_stamp(time.time())} {text}"
