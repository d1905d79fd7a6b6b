"""The thread to which the frames of all cameras come: for the second it need not be woken."""

from __future__ import annotations

import select
import threading
from typing import Protocol


class Receives(Protocol):
    """One end of a link."""

    def fileno(self) -> int:
        """The link's descriptor."""

    def take(self) -> bool:
        """Take what has come; False if nothing more will."""

    def give_back(self) -> None:
        """Say what is no longer looked at."""

    def end(self) -> None:
        """Called once, when nothing more is taken."""


class FrameThread:
    """Takes what comes over several links; begins with the first and ends with the last of them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._heard = select.epoll()
        self._ends: dict[int, Receives] = {}
        self._thread: threading.Thread | None = None

    @property
    def is_current(self) -> bool:
        """Whether this is the thread that asks."""
        return threading.current_thread() is self._thread

    def add(self, end: Receives) -> None:
        """Take what comes over one more link, from now on; any thread may say so."""
        with self._lock:
            self._ends[end.fileno()] = end
            self._heard.register(end.fileno(), select.EPOLLIN)
            if len(self._ends) == 1:
                self._thread = threading.Thread(target=self._run, name="frames", daemon=True)
                self._thread.start()

    def _run(self) -> None:
        while True:
            # What came meanwhile is more urgent than what is no longer looked at.
            for patience_s in (None, 0.0):
                for descriptor, _ in self._heard.poll(patience_s):
                    end = self._ends[descriptor]
                    if not end.take() and self._is_last(end):
                        return
            for end in list(self._ends.values()):
                end.give_back()

    def _is_last(self, end: Receives) -> bool:
        with self._lock:
            self._heard.unregister(end.fileno())
            del self._ends[end.fileno()]
            is_last = not self._ends
        end.end()
        return is_last
