"""Real-time priority: a service that others wait for runs before every ordinary process."""

from __future__ import annotations

import os
import threading

from fairlead.errors import ConfigError


def realtime_words(service: str, priority: int) -> list[str]:
    """What to put before a command so that it and its threads run at a real-time priority.

    Args:
        priority: of ``SCHED_FIFO``, 1 to 99; 0: none, no words.

    Raises:
        ConfigError: the system does not permit it.
    """
    if not priority:
        return []
    if not _is_permitted(priority):
        raise ConfigError(
            f"service {service}: realtime_priority: expected the permission for {priority} "
            "(ulimit -r; in /etc/security/limits.conf: USER - rtprio 99), got none; allow it or "
            "leave realtime_priority out"
        )
    return ["/usr/bin/chrt", "--fifo", str(priority)]


def run_as_ordinary_process() -> None:
    """For a helper process that computes for long: it does not inherit its parent's priority."""
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _is_permitted(priority: int) -> bool:
    """Tried on a thread that then ends: a priority is a thread's."""
    permitted: list[bool] = []

    def attempt() -> None:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except PermissionError:
            return
        permitted.append(True)

    thread = threading.Thread(target=attempt)
    thread.start()
    thread.join()
    return bool(permitted)
