"""SIGTERM and SIGINT of a service: heard whichever thread they reach, and always obeyed."""

from __future__ import annotations

import faulthandler
import os
import signal
import socket
import sys
import threading
from types import FrameType

from fairlead.log_stamp import stamped

END_S = 4.0
"""A service ends by itself within this time of being asked; then it is ended."""


class StopSignals:
    """Sets ``stopping`` on SIGTERM or SIGINT.

    Python runs signal handlers in the main thread, between two of its instructions. A signal
    that the kernel hands to a thread of the transport does not interrupt a main thread that
    waits, which would then wait for ever; so a thread of our own reads the signals from the
    interpreter's wake-up socket. Create it in the main thread, once a process.

    Args:
        who: named in the line that is printed if the service does not end in time.
    """

    def __init__(self, who: str) -> None:
        self.stopping = threading.Event()
        self._who = who
        self._starting = True
        self._ending = threading.Lock()  # taken once, by the first reason to end
        self._wake, wake_end = socket.socketpair()
        wake_end.setblocking(False)
        signal.set_wakeup_fd(wake_end.detach(), warn_on_full_buffer=False)
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._on_signal)
        threading.Thread(target=self._read, name="stop signals", daemon=True).start()

    def started(self) -> None:
        """From now on the service does something that has to be ended in order."""
        self._starting = False

    def end_in_time(self) -> None:
        """From now on the process has `END_S` left, whatever still hangs in it."""
        if self._ending.acquire(blocking=False):
            timer = threading.Timer(END_S, self._end)
            timer.daemon = True
            timer.start()

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        """Only there so that the interpreter takes the signal; `_read` acts on it."""

    def _read(self) -> None:
        while signalled := self._wake.recv(64):
            if {signal.SIGTERM, signal.SIGINT} & set(signalled):
                if self._starting:  # may be deep in a simulator's set-up; nothing moves yet
                    self._print("INFO", "asked to end while starting")
                    os._exit(0)
                self.stopping.set()
                self.end_in_time()

    def _end(self) -> None:
        faulthandler.dump_traceback(sys.stderr)  # where every thread hangs
        self._print("ERROR", f"did not end within {END_S:g} s, ended")
        os._exit(1)

    def _print(self, level: str, text: str) -> None:
        """Not by logging, whose locks another thread may hold just now."""
        print(stamped(f"{level} {self._who}: {text}", self._who), flush=True)
