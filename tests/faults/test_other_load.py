"""Whose CPU time counts as the robot's own, and whose as others'."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

from bench.faults.other_load import OtherLoad, own_s

BUSY = "import time\nwhile time.process_time() < 1.0: pass\nprint(flush=True)\n"
BUSY_S = 1.0
BELOW = f"""
import subprocess, sys
subprocess.run([sys.executable, "-c", {BUSY!r}])
sys.stdin.read()
"""
APART = f"""
import subprocess, sys
subprocess.Popen([sys.executable, "-c", {BUSY!r}])
"""


@pytest.mark.processes
def test_a_childs_child_is_own_while_it_runs_and_after_its_end() -> None:
    before_s = own_s()
    with subprocess.Popen(
        [sys.executable, "-c", BELOW], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as child:
        assert child.stdout is not None and child.stdout.readline() == b"\n"
        assert own_s() - before_s > 0.9 * BUSY_S
    assert own_s() - before_s > 0.9 * BUSY_S


@pytest.mark.processes
def test_a_process_that_is_nobodys_child_is_one_of_the_others() -> None:
    load, before_s, began_s = OtherLoad(), own_s(), time.monotonic()
    subprocess.run([sys.executable, "-c", APART], check=True, stdout=subprocess.PIPE)
    assert own_s() - before_s < 0.9 * BUSY_S
    assert load.cores() * (time.monotonic() - began_s) > 0.9 * BUSY_S
