"""Children that cannot outlive the supervisor, even when it is killed with SIGKILL."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence

from fairlead.errors import ServiceError

_IF_PARENT_LIVES = '[ "$PPID" = "$0" ] && exec "$@"'


def die_with_parent(command: Sequence[str]) -> list[str]:
    """The command, started so that the kernel ends it with the *thread* that forked it.

    So children must be started from a thread that lives as long as the supervisor. Python's
    ``preexec_fn`` would do the same, but hangs now and then in a process with threads of Zenoh's:
    one of them may hold a lock of the interpreter at the moment of the fork.

    Raises:
        ServiceError: ``setpriv`` (of util-linux) is not there.
    """
    setpriv = shutil.which("setpriv")
    if setpriv is None:
        raise ServiceError("setpriv, which starts services, is not found; apt install util-linux")
    # The shell looks whether the parent died before the kernel knew.
    check = ["/bin/sh", "-c", _IF_PARENT_LIVES, str(os.getpid())]
    return [setpriv, "--pdeathsig", "KILL", "--", *check, *command]
