"""A service that is asked to stop: it hears it, and it ends."""

from __future__ import annotations

import ctypes
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bench.equipment.live_robot import wait_for

pytestmark = pytest.mark.processes

SCRIPT = Path(__file__).with_name("stubborn_service.py")

Start = Callable[[str], "subprocess.Popen[str]"]

DEPLOYMENT = """\
robot: panda_mobile
id: panda_mobile
services:
  runner:
    run: skill_runner
"""


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    started: list[subprocess.Popen[str]] = []

    def run(mode: str) -> subprocess.Popen[str]:
        deployment = tmp_path / "deployment.yaml"
        deployment.write_text(DEPLOYMENT)
        arguments = ["--deployment", deployment, "--service", "runner", "--state-dir", tmp_path]
        process = subprocess.Popen(
            [sys.executable, SCRIPT, mode, *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        started.append(process)
        assert process.stdout is not None
        assert "ready" in process.stdout.readline()
        return process

    yield run
    for process in started:
        assert process.stdout is not None
        process.kill()
        process.wait()
        process.stdout.close()


def rest(process: subprocess.Popen[str]) -> str:
    """What it says until it ends; `communicate` would lose what came together with "ready"."""
    assert process.stdout is not None
    output = process.stdout.read()
    process.wait(timeout=10)
    return output


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_waiting_service_ends_cleanly_when_asked(start: Start, number: signal.Signals) -> None:
    process = start("plain")
    process.send_signal(number)
    assert process.wait(timeout=10) == 0


def test_a_signal_that_reaches_another_thread_is_heard_too(start: Start) -> None:
    process = start("plain")
    entries = Path(f"/proc/{process.pid}/task").iterdir()
    tasks = {int(entry.name) for entry in entries} - {process.pid}
    assert tasks, "the transport has threads"
    assert ctypes.CDLL(None).tgkill(process.pid, max(tasks), int(signal.SIGTERM)) == 0
    assert process.wait(timeout=10) == 0


@pytest.mark.parametrize("mode", ["deaf", "thread"])
def test_a_service_that_hangs_when_asked_to_stop_is_ended_and_says_where(
    start: Start, mode: str
) -> None:
    process = start(mode)
    process.terminate()
    output = rest(process)
    assert process.returncode == 1
    assert "ERROR stubborn: did not end within 0.5 s, ended" in output
    assert "threading.py" in output, "the stack of the hanging thread"


def test_a_service_asked_to_stop_while_it_starts_ends_at_once_and_says_so(start: Start) -> None:
    process = start("starting")
    process.send_signal(signal.SIGINT)
    output = rest(process)
    assert process.returncode == 0
    assert output.endswith("Z INFO stubborn: asked to end while starting\n")


@pytest.mark.parametrize(("mode", "code"), [("starting", 0), ("deaf", 1)])
def test_a_service_whose_output_nobody_reads_any_more_ends_too(
    start: Start, mode: str, code: int
) -> None:
    process = start(mode)
    assert process.stdout is not None
    process.stdout.close()
    process.terminate()
    assert process.wait(timeout=10) == code


def test_a_service_whose_reader_is_paused_goes_on(start: Start, tmp_path: Path) -> None:
    process = start("talks")
    wait_for((tmp_path / "talked").exists, "it goes on though nobody reads")
    process.terminate()
    output = rest(process)
    assert process.returncode == 0
    numbers = [int(n) for n in re.findall(r" INFO talks: line (\d+) ", output)]
    assert numbers[:300] == [*range(300)], "all that a pipe holds"
    assert numbers == sorted(set(numbers)) and len(numbers) < 3000, "others are left out"


def test_a_task_that_fails_ends_its_service_with_one_line_that_says_why(start: Start) -> None:
    process = start("task")
    output = rest(process)
    assert process.returncode == 1
    assert output.count("ERROR") == 1
    assert "ERROR stubborn: internal error, KeyError: 'no such part'" in output
