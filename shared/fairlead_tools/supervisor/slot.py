"""One service's place in a supervisor: its process now, what it came from, when it is restarted."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

from fairlead.deploy.registry import ServiceEntry
from fairlead_tools.supervisor.child import Child

FIRST_DELAY_S = 0.5
LONGEST_DELAY_S = 10.0
FORGIVEN_AFTER_S = 30.0  # a service that ran this long starts over at the first delay


@dataclass
class Backoff:
    """Doubling delays, forgotten after a long enough life."""

    _next_s: float = FIRST_DELAY_S

    def delay_s(self, lived_s: float) -> float:
        """The delay [s] for a process that died after ``lived_s`` seconds."""
        if lived_s >= FORGIVEN_AFTER_S:
            self._next_s = FIRST_DELAY_S
        delay = self._next_s
        self._next_s = min(2.0 * delay, LONGEST_DELAY_S)
        return delay


@dataclass
class Slot:
    """A child, when it was started, and how often again.

    files: digest of each file that its command names, when it was started.
    told: whether somebody was told that this child is ready.
    """

    child: Child
    started_s: float
    files: dict[str, str]
    backoff: Backoff = field(default_factory=Backoff)
    restarts: int = 0
    told: bool = False

    @property
    def entry(self) -> ServiceEntry:
        """What the registry says of it."""
        return ServiceEntry(self.child.process_id, self.child.ready, self.restarts)

    @property
    def start_failed(self) -> bool:
        """Whether its first process ended before it was ready."""
        return self.child.ended and not self.restarts and not self.child.ready

    def replace(self, child: Child, files: dict[str, str], now_s: float) -> list[str]:
        """Take the process that was started again.

        Returns:
            The files that changed since the last start.
        """
        changed = [file for file, digest in files.items() if self.files.get(file) != digest]
        self.child, self.files, self.started_s, self.told = child, files, now_s, False
        self.restarts += 1
        return changed


def digests(command: list[str]) -> dict[str, str]:
    """SHA-256 of each file that is an argument of a command."""
    files = [word for word in command[1:] if word.startswith("/") and Path(word).is_file()]
    return {file: hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in files}
