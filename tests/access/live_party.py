"""A party as a process of its own, and what came through at any of them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence

from bench.equipment.live_robot import wait_for
from tests.access.party import Passed

QUIET_S = 0.3
"""So long nothing came any more: what has not come by then does not come."""
WAIT_S = 60.0
LOST_S = 10.0
"""What was expected and has not come by then is lost."""


class Found:
    """What came through, from every process."""

    def __init__(self) -> None:
        self._passed: set[Passed] = set()
        self._changed_s = time.monotonic()
        self._lock = threading.Lock()

    def add(self, passed: Passed) -> None:
        with self._lock:
            if passed not in self._passed:
                self._passed.add(passed)
                self._changed_s = time.monotonic()

    def settled(
        self,
        is_enough: Callable[[set[Passed]], bool],
        sender_of: Callable[[str], str] = str,
    ) -> set[Passed]:
        """What came until it is enough, or long enough; then all is forgotten.

        Args:
            sender_of: who declared a token that somebody sees.
        """
        began_s = time.monotonic()

        def seen() -> set[Passed]:
            with self._lock:
                named = {p._replace(sender=p.sender or sender_of(p.receiver)) for p in self._passed}
            return {p for p in named if p.sender != p.receiver}  # one sees its own tokens, too

        def is_over() -> bool:
            now_s = time.monotonic()
            quiet = now_s - max(self._changed_s, began_s) > QUIET_S
            return quiet and (is_enough(seen()) or now_s - began_s > LOST_S)

        wait_for(is_over, "it settles", 2 * WAIT_S)
        passed = seen()
        with self._lock:
            self._passed.clear()
        return passed


def all_came(_: set[Passed]) -> bool:
    """Nothing is waited for."""
    return True


class LiveParty:
    """A process of its own: `tests.access.party`, with these arguments.

    Args:
        first: words before the command.
        environment: what it has besides the caller's.
    """

    def __init__(
        self,
        arguments: Sequence[str],
        found: Found,
        first: Sequence[str] = (),
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self.name = " ".join(arguments)
        self.process = subprocess.Popen(
            [*first, sys.executable, "-m", "tests.access.party", *arguments],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1,
            env=os.environ | dict(environment or {}),
        )  # fmt: skip
        self._ready, self._rested = threading.Event(), threading.Event()
        self._reader = threading.Thread(target=self._read, args=(found,))
        self._reader.start()

    def _read(self, found: Found) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if line == "ready\n":
                self._ready.set()
            elif line == "rested\n":
                self._rested.set()
            elif line.startswith("["):
                found.add(Passed(*json.loads(line)))

    def wait_ready(self) -> None:
        assert self._ready.wait(WAIT_S), f"{self.name} was not ready"

    def say(self, word: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{word}\n")

    def rest(self, word: str = "rest") -> None:
        """Once this returns it does not see its own tokens in the place of another's."""
        self._rested.clear()
        self.say(word)
        assert self._rested.wait(WAIT_S), f"{self.name} did not rest"

    def close(self) -> None:
        self.process.kill()
        self._reader.join(WAIT_S)
        self.process.communicate(timeout=WAIT_S)
