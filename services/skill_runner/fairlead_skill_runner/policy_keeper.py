"""Keeps a policy's process, and ends all that it started: ``python policy_keeper.py FD COMMAND``.

Starts the command with the number of the runner's socket, FD, after it. When the policy's process
has ended, or nobody holds this one's standard input any more, it ends whatever is left: processes
whose parent has ended become its own children, whatever group or session they are in. Its exit
status is the policy's.

Uses Python's own library alone, to be there in no time.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from pathlib import Path

_SET_CHILD_SUBREAPER = 36  # of prctl


def main() -> int:
    """Until the policy has ended, and all that it started."""
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))  # of a runner with a priority
    if ctypes.CDLL(None, use_errno=True).prctl(_SET_CHILD_SUBREAPER, 1, 0, 0, 0):
        raise OSError(ctypes.get_errno(), "prctl")
    runner, *command = sys.argv[1:]
    nothing = (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0)
    policy = os.posix_spawnp(
        command[0], [*command, runner], os.environ, file_actions=[nothing], setpgroup=0
    )
    os.close(int(runner))  # the policy's alone: it tells the runner when that has ended
    threading.Thread(target=_end_with_runner, args=(os.pidfd_open(policy),), daemon=True).start()
    while (ended := os.waitpid(-1, 0))[0] != policy:
        continue
    _end_the_rest()
    status = os.waitstatus_to_exitcode(ended[1])
    if status < 0:
        if -status != signal.SIGKILL:
            signal.signal(-status, signal.SIG_DFL)  # Python takes or ignores a few
        os.kill(os.getpid(), -status)
    return status


def _end_with_runner(policy: int) -> None:
    while os.read(0, 1):
        continue
    signal.pidfd_send_signal(policy, signal.SIGKILL)


def _end_the_rest() -> None:
    """Those of another user, whom nobody here can end, live on."""
    while ending := [pid for pid in _children() if _kill(pid)]:
        os.waitpid(ending[0], 0)


def _children() -> list[int]:
    """Of every thread: a process is adopted by any of them."""
    lists = Path("/proc/self/task").glob("*/children")
    return [int(pid) for one in lists for pid in one.read_text(encoding="ascii").split()]


def _kill(pid: int) -> bool:
    try:
        os.kill(pid, signal.SIGKILL)
    except PermissionError:
        return False
    return True


if __name__ == "__main__":
    raise SystemExit(main())
