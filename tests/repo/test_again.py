"""A test that is tried again (`tests/late_machine.py`)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.late_machine import BUSY_TRIES, current, is_late
from tests.repo.tree import ROOT

HANGS = """
import pathlib, threading, pytest
@pytest.mark.flaky(reruns=1)
@pytest.mark.timeout(2)
def test_fails_then_hangs():
    marker = pathlib.Path(__file__).with_suffix(".tried")
    if marker.exists():
        threading.Event().wait()
    marker.touch()
    pytest.fail("the first try")
"""


@pytest.mark.processes
def test_each_try_has_its_time_limit_and_why_each_failed_is_told(tmp_path: Path) -> None:
    (tmp_path / "pytest.ini").touch()
    (tmp_path / "test_it.py").write_text(HANGS)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "tests.conftest", tmp_path],
        cwd=tmp_path, capture_output=True, text=True, timeout=60,
        env=os.environ | {"PYTHONPATH": str(ROOT), "PYTEST_ADDOPTS": ""},
    )  # fmt: skip
    assert done.returncode == 1, done.stdout + done.stderr
    assert "AGAIN test_it.py::test_fails_then_hangs: Failed: the first try" in done.stdout
    assert "Failed: Timeout (>2.0s)" in done.stdout


def test_on_a_busy_machine_a_bug_of_a_service_is_no_reason_to_try_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(os, "getloadavg", lambda: (1e3, 0.0, 0.0))
    assert is_late(AssertionError("deadline instead of succeeded"))
    assert not is_late(AssertionError("ERROR internal error, KeyError: 'x'"))
    monkeypatch.setitem(current, "try", BUSY_TRIES)
    assert not is_late(AssertionError("deadline instead of succeeded"))
    monkeypatch.setattr(os, "getloadavg", lambda: (0.0, 0.0, 0.0))
    assert not is_late(AssertionError("deadline instead of succeeded"))
    assert is_late(AssertionError("G003: state_timeout_ms"))
