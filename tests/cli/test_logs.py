"""``fairlead logs``: in order of time, and on while the services write."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from fairlead_tools.supervisor.service_log import ServiceLog
from tests.cli.command import fairlead, fairlead_command, fairlead_environment

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
    process = subprocess.Popen(
        fairlead_command("logs", "--state-dir", str(tmp_path / "state"), "--follow"),
        env=fairlead_environment(tmp_path),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == f"[hal] {WHEN.format(0, 'hal', 'before')}\n"
        for number in range(1, 6):  # two of them fill a file
            logs["hal"].append(WHEN.format(number, "hal", "after"))
            assert process.stdout.readline() == f"[hal] {WHEN.format(number, 'hal', 'after')}\n"
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=20.0)[0] == ""
        assert process.returncode == 0
    finally:
        process.kill()
