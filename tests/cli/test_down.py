"""``fairlead down`` ends what runs when its supervisor has ended, whatever the list said before.

``fairlead restart`` ends nothing that nobody would start again.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest

from fairlead.deploy.process_table import ProcessId, process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead.paths import repo_root
from tests.cli.command import fairlead as in_a_process
from tests.cli.command import fairlead_here as fairlead

pytestmark = pytest.mark.processes

SUPERVISOR = """
import signal, sys
from pathlib import Path

def last_word(number, frame):
    Path(sys.argv[1]).write_bytes(Path(sys.argv[2]).read_bytes())
    sys.exit(0)

signal.signal(signal.SIGTERM, last_word)
print("ready", flush=True)
while True:
    signal.pause()
"""
"""Replaces what is listed by something else while it is being ended."""

FILE = repo_root() / "compose" / "panda_mujoco.yaml"
ENDED = ProcessId(0, 0)  # nobody has this number


def service(process: ProcessId) -> dict[str, ServiceEntry]:
    return {"hal": ServiceEntry(process, True, 0)}


def started(process: subprocess.Popen[bytes]) -> ProcessId:
    found = process_id(process.pid)
    assert found is not None
    return found


@contextmanager
def running(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    with subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"ready\n"
            yield process
        finally:
            process.kill()


@pytest.fixture
def bystander() -> Iterator[subprocess.Popen[bytes]]:
    """Some process that runs on."""
    with running("-c", "import time; print('ready', flush=True); time.sleep(1000)") as process:
        yield process


def down(tmp_path: Path, listed: dict[str, ServiceEntry], last: Running) -> str:
    """End a deployment that lists ``last`` when its supervisor is asked to end."""
    first, entry = Registry(tmp_path / "state"), Registry(tmp_path / "later")
    entry.write(last)
    [kept] = (tmp_path / "later" / "running").glob("*.json")
    file = tmp_path / "state" / "running" / kept.name
    with running("-c", SUPERVISOR, str(file), str(kept)) as supervisor:
        first.write(Running("r", "r.yaml", str(tmp_path), started(supervisor), listed))
        done = fairlead("down", "r", state=tmp_path / "state")
        assert done.returncode == 0, done.stderr
        assert supervisor.wait(timeout=10.0) == 0
    return done.stdout


def test_what_its_supervisor_started_while_it_was_ended_is_ended_too(
    tmp_path: Path, bystander: subprocess.Popen[bytes]
) -> None:
    last = Running("r", "r.yaml", str(tmp_path), ENDED, service(started(bystander)))
    assert down(tmp_path, service(ENDED), last) == "stopped r and 1 leftover process\n"
    assert bystander.wait(timeout=10.0) != 0


def test_what_somebody_started_by_hand_is_named_as_that(
    tmp_path: Path, bystander: subprocess.Popen[bytes]
) -> None:
    by_hand = {"runner": ServiceEntry(started(bystander), True, 0, by_hand=True)}
    registry = Registry(tmp_path / "state")
    registry.write_by_hand("runner", Running("r", str(FILE), str(tmp_path), None, by_hand), False)
    done = fairlead("down", "r", state=tmp_path / "state")
    assert done.stdout == "stopped r and runner (started by hand)\n", done.stderr
    assert bystander.wait(timeout=10.0) != 0


def test_a_process_that_got_the_number_of_one_that_is_listed_is_left_alone(
    tmp_path: Path, bystander: subprocess.Popen[bytes]
) -> None:
    earlier = ProcessId(bystander.pid, 1)
    last = Running("r", "r.yaml", str(tmp_path), ENDED, service(earlier))
    assert down(tmp_path, service(earlier), last) == "stopped r\n"
    assert bystander.poll() is None


def test_what_somebody_has_started_anew_meanwhile_is_left_alone(
    tmp_path: Path, bystander: subprocess.Popen[bytes]
) -> None:
    other = started(bystander)
    last = Running("r", "r.yaml", str(tmp_path), other, service(other))
    assert down(tmp_path, service(other), last) == "stopped r\n"
    assert bystander.poll() is None


def test_a_service_whose_supervisor_is_paused_is_not_restarted(
    tmp_path: Path, bystander: subprocess.Popen[bytes]
) -> None:
    with running("-c", SUPERVISOR) as supervisor:
        listed = service(started(bystander))
        entry = Running("r", str(FILE), str(tmp_path), started(supervisor), listed)
        Registry(tmp_path / "state").write(entry)
        supervisor.send_signal(signal.SIGSTOP)
        os.waitpid(supervisor.pid, os.WUNTRACED)
        done = fairlead("restart", "hal", state=tmp_path / "state")
        assert done.stderr == (
            f"ERROR hal: `fairlead up` (pid {supervisor.pid}) is paused, so it would not start it "
            f"again; let it go on: kill -CONT {supervisor.pid}\n"
        )
    assert bystander.poll() is None


def test_a_supervisor_that_is_paused_once_its_service_was_ended_is_named(
    tmp_path: Path, bystander: subprocess.Popen[bytes]
) -> None:
    registry = Registry(tmp_path / "state")
    with running("-c", SUPERVISOR) as supervisor, ThreadPoolExecutor(1) as person:
        listed = service(started(bystander))
        registry.write(Running("r", str(FILE), str(tmp_path), started(supervisor), listed))
        asked = person.submit(in_a_process, "restart", "hal", state=registry.root)
        assert bystander.wait(timeout=60.0) != 0
        supervisor.send_signal(signal.SIGSTOP)
        said = asked.result(timeout=60.0).stderr
    assert said.startswith(f"ERROR hal: `fairlead up` (pid {supervisor.pid}) is paused")


def test_what_an_earlier_gate_left_is_told_as_its(
    tmp_path: Path, bystander: subprocess.Popen[bytes]
) -> None:
    (tmp_path / "safety").mkdir()
    (tmp_path / "safety" / "gate.lock").touch()
    last = Running("r", "r.yaml", str(tmp_path), ENDED, service(ENDED))
    assert down(tmp_path, service(started(bystander)), last) == (
        "stopped r\nits last gate (safety) did not end disarmed: it will start latched, "
        "until fairlead reset\n"
    )
