"""What is tried again: in realtime the gate rightly stops a robot whose machine is too busy.

Every test that starts processes has this mark (`tests/conftest.py`), which prints at the end why
each one was tried again. Whose bound is at stake measures the machine beside it.
"""

from __future__ import annotations

import os
import re

import pytest

from bench.faults.row import MachineLateError

LOAD_PER_CORE = 1.0
"""Above it a machine is busy: more processes want to run than it has cores."""
BUG = "internal error"
"""What a service says of an exception that nobody expected: no machine is late enough for one."""
SAYS = re.compile("state_timeout_ms|observation too new|claim of (measure|teleop|jog|home) lost")


BUSY_TRIES = 3
"""So many in all where nothing but the load speaks for a late machine."""
current = {"try": 1}
"""The try of the test that runs, from 1 (`tests/conftest.py` counts)."""


def is_busy() -> bool:
    """Whether so many processes want to run, in the last minute."""
    return os.getloadavg()[0] > LOAD_PER_CORE * (os.cpu_count() or 1)


def is_late(error: BaseException) -> bool:
    """Whether a failure says that states came late, or the machine is busy as it happens.

    The load alone counts for the first tries only. Not where it shows a bug, which a race may
    bring out only now and then.
    """
    if BUG in str(error):
        return False
    says_so = isinstance(error, MachineLateError) or SAYS.search(str(error)) is not None
    return says_so or (current["try"] < BUSY_TRIES and is_busy())


LATE = pytest.mark.flaky(reruns=4, reruns_delay=3, condition=is_late)
"""Shown as R. Not at once: what made the machine late may be over then."""
