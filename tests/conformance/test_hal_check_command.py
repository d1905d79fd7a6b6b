"""The command: its table, its document, its exit code, and what it refuses."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fairlead.paths import deployment_path, repo_root
from fairlead_tools.supervisor.command_line import service_command
from tests.cli.command import fairlead, fairlead_here
from tests.conformance.quick_robot import NAME, write_quick_robot
from tests.conformance.running_hal import RunningHal, Wanted, running_hal

pytestmark = pytest.mark.processes

EXAMPLE = repo_root() / "docs" / "examples" / "minimal_hal.py"


@pytest.fixture(scope="module")
def hal(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningHal]:
    """The example of the document: a program that no package registers."""
    wanted = Wanted("panda", {"command": ["python", str(EXAMPLE)]})
    with running_hal(tmp_path_factory.mktemp("command"), "panda", wanted) as running:
        yield running


def test_a_hal_that_is_no_simulator_is_not_moved_unasked(hal: RunningHal, tmp_path: Path) -> None:
    done = fairlead_here("hal", "check", str(hal.file), state=tmp_path)
    assert done.returncode == 1
    assert "no simulator's: the robot will move, and no gate judges how" in done.stderr
    assert "--yes" in done.stderr
    assert b"WARNING" not in hal.log.read_bytes()


def test_a_gate_that_is_alive_is_named_and_nothing_is_sent(hal: RunningHal, tmp_path: Path) -> None:
    words = [*service_command(hal.file, hal.deployment, "safety", tmp_path), "--new-state"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as gate:
        try:
            assert gate.stdout is not None and any("session" in line for line in gate.stdout)
            done = fairlead_here("hal", "check", str(hal.file), "--yes", state=tmp_path)
        finally:
            gate.kill()
    assert done.returncode == 1
    assert "a gate is alive on this robot's bus" in done.stderr
    assert "--without safety" in done.stderr


def test_where_no_hal_runs_it_says_how_to_start_one(tmp_path: Path) -> None:
    file = deployment_path("so101_mujoco")
    done = fairlead_here("hal", "check", str(file), "--json", state=tmp_path)
    assert done.returncode == 1
    error = json.loads(done.stdout)["error"]
    assert error["kind"] == "NoAnswerError"
    assert "fairlead up NAME --without safety" in error["message"]


def test_a_broken_one_fails_with_what_was_expected_and_a_fix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(write_quick_robot(tmp_path / "robots")))
    command = ["python", "-m", "bench.equipment.broken_hal"]
    wanted = Wanted(NAME, {"command": command, "options": {"fault": "drifts"}})
    with running_hal(tmp_path, "drifting", wanted) as running:
        words = ["hal", "check", str(running.file), "--yes", "--hold-s", "0.5"]
        table = fairlead(*words, state=tmp_path)
        document = _document(fairlead_here(*words, "--json", state=tmp_path))
    assert table.returncode == 1
    assert "FAILED a hold does not drift: elbow_joint moved by" in table.stdout
    assert "fix: keep one setpoint" in table.stdout
    assert "Traceback" not in table.stderr
    [row] = [one for one in document["rows"] if one["check"] == "a hold does not drift"]
    assert (row["outcome"], document["good"]) == ("fail", False)


def _document(done: subprocess.CompletedProcess[str]) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(done.stdout)
    return found
