"""Children that cannot outlive the supervisor, even when it is killed with SIGKILL."""

from __future__ import annotations

import ctypes
import os
import signal
from collections.abc import Callable

_PR_SET_PDEATHSIG = 1  # linux/prctl.h
# Loaded here, before any fork: the child may only call what is already in memory.
_LIBC = ctypes.CDLL(None, use_errno=True)


def die_with_parent() -> Callable[[], None]:
    """A function for the child to call between fork and exec.

    The kernel then sends the child SIGKILL when the *thread* that forked it ends, so
    children must be started from a thread that lives as long as the supervisor.
    """
    parent = os.getpid()

    def in_child() -> None:
        _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # the parent died before the line above
            os._exit(1)

    return in_child
