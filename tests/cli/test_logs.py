"""``fairlead logs``: in order of time, and on while the services write."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead_tools.supervisor.service_log import ServiceLog
from tests.cli.command import fairlead_command, fairlead_environment
from tests.cli.command import fairlead_here as fairlead

pytestmark = pytest.mark.processes

WHEN = "2026-11-23T07:54:0{}.000Z INFO {}: {}"


@pytest.fixture
def logs(tmp_path: Path) -> Iterator[dict[str, ServiceLog]]:
    folder = tmp_path / "state" / "logs"
    written = {name: ServiceLog(folder / f"{name}.log", 120) for name in ("hal", "safety")}
    yield written
    for log in written.values():
        log.close()


def test_lines_of_all_services_come_in_order_of_time(
    logs: dict[str, ServiceLog], tmp_path: Path
) -> None:
    for second, name in enumerate(("safety", "hal", "hal", "safety")):
        logs[name].append(WHEN.format(second, name, "x"))
    words = ("logs", "--state-dir", str(tmp_path / "state"))
    done = fairlead(*words, state=tmp_path)
    assert [line.split("]")[0] for line in done.stdout.splitlines()] == [
        "[safety", "[hal", "[hal", "[safety",
    ]  # fmt: skip
    document = json.loads(fairlead(*words, "-n", "1", "--json", state=tmp_path).stdout)
    assert document == {
        "hal": [WHEN.format(2, "hal", "x")],
        "safety": [WHEN.format(3, "safety", "x")],
    }


def test_following_prints_what_is_added_also_in_a_new_file_until_interrupted(
    logs: dict[str, ServiceLog], tmp_path: Path
) -> None:
    logs["hal"].append(WHEN.format(0, "hal", "before"))
    with following(tmp_path, "--state-dir", str(tmp_path / "state")) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == f"[hal] {WHEN.format(0, 'hal', 'before')}\n"
        for number in range(1, 6):  # two of them fill a file
            logs["hal"].append(WHEN.format(number, "hal", "after"))
            assert process.stdout.readline() == f"[hal] {WHEN.format(number, 'hal', 'after')}\n"
        logs["safety"].append(WHEN.format(6, "safety", "late"))  # its first
        assert process.stdout.readline() == f"[safety] {WHEN.format(6, 'safety', 'late')}\n"
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=20.0)[0] == "interrupted\n"
        assert process.returncode == 130


def test_a_service_that_has_printed_nothing_yet_is_followed(
    logs: dict[str, ServiceLog], tmp_path: Path
) -> None:
    starting = {name: ServiceEntry(None, False, 0) for name in ("hal", "safety")}
    own = process_id(os.getpid())
    Registry(tmp_path).write(Running("r", "r.yaml", str(tmp_path / "state"), own, starting))
    assert (said := fairlead("logs", "safety", state=tmp_path)).returncode == 0, said.stderr
    assert said.stdout == ""
    assert "(valid: hal, safety)" in fairlead("logs", "gate", "-f", state=tmp_path).stderr
    with following(tmp_path, "safety") as process:
        logs["hal"].append(WHEN.format(0, "hal", "another"))
        logs["safety"].append(WHEN.format(1, "safety", "first"))
        assert process.stdout is not None
        assert process.stdout.readline() == f"[safety] {WHEN.format(1, 'safety', 'first')}\n"


@contextmanager
def following(state: Path, *words: str) -> Iterator[subprocess.Popen[str]]:
    """``fairlead logs --follow``, which does not outlive the block."""
    with subprocess.Popen(
        fairlead_command("logs", "--follow", *words),
        env=fairlead_environment(state),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()
