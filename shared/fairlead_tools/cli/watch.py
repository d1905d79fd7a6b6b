"""Show something again and again: in place on a terminal, block after block elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import suppress

from fairlead.log_stamp import utc_stamp
from fairlead_tools.cli.console import echo

AGAIN_S = 1.0
_CLEAR = "\x1b[H\x1b[J"  # to the top left corner; nothing below


def watch(look: Callable[[], list[str]]) -> None:
    """Print the lines that ``look`` finds, every second until Ctrl-C, each time with the time."""
    with suppress(KeyboardInterrupt):
        while True:
            lines = look()
            if sys.stdout.isatty():
                sys.stdout.write(_CLEAR)
            echo("\n".join([utc_stamp(time.time()), *lines]))
            time.sleep(AGAIN_S)
