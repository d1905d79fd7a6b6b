"""SIGTERM and SIGINT of a service: heard on its event loop, and obeyed within a time."""

from __future__ import annotations

import asyncio
import faulthandler
import os
import signal
import sys
import threading

from fairlead.log_output import flush_log
from fairlead.log_stamp import stamped

END_S = 4.0
"""A service ends by itself within this time of being asked; then it is ended."""


class StopSignals:
    """Sets ``stopping`` on SIGTERM or SIGINT.

    Create it on the event loop of the main thread, once a process. The loop hears a signal
    whichever thread the kernel hands it to.

    Args:
        who: named in the line that is printed if the service does not end in time.
    """

    def __init__(self, who: str) -> None:
        self.stopping = asyncio.Event()
        self._who = who
        self._starting = True
        self._deadline: threading.Timer | None = None
        for number in (signal.SIGTERM, signal.SIGINT):
            asyncio.get_running_loop().add_signal_handler(number, self._on_signal)

    def started(self) -> None:
        """From now on the service does something that has to be ended in order."""
        self._starting = False

    def end_in_time(self) -> None:
        """From now on the process has `END_S` left, whatever still hangs in it, its loop too."""
        if self._deadline is None:
            self._deadline = threading.Timer(END_S, self._end)
            self._deadline.daemon = True
            self._deadline.start()

    def _on_signal(self) -> None:
        if self._starting:  # a thread may be deep in a simulator's set-up; nothing moves yet
            try:
                self._print("INFO", "asked to end while starting")
            finally:  # who reads it may be gone
                os._exit(0)
        self.stopping.set()
        self.end_in_time()

    def _end(self) -> None:
        try:
            faulthandler.dump_traceback(sys.stderr)  # where every thread hangs
            self._print("ERROR", f"did not end within {END_S:g} s, ended")
        finally:
            os._exit(1)

    def _print(self, level: str, text: str) -> None:
        """Not by logging, whose locks another thread may hold just now."""
        flush_log()
        print(stamped(f"{level} {self._who}: {text}", self._who), flush=True)


def ignore_further_signals() -> None:
    """For a process that is about to end: asked once more, it ends as it was going to."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)
