"""The demo as a newcomer runs it, also after an earlier one was killed in the middle."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from pathlib import Path

import pytest

from bench.equipment.live_robot import wait_for
from tests.cli.command import fairlead, fairlead_command, fairlead_environment
from tests.cli.process_list import pids_that_mention

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(400)]


def processes_in(folder: Path) -> list[int]:
    return pids_that_mention(folder / "state")


@pytest.mark.thorough
def test_after_one_that_was_killed_the_demo_does_the_task_challenges_the_gate_and_draws_it(
    tmp_path: Path,
) -> None:
    out, registry = tmp_path / "demo", tmp_path / "registry"
    with subprocess.Popen(
        fairlead_command("demo", "--out", str(out)),
        env=fairlead_environment(registry),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as first:
        log = out / "state" / "logs" / "runner.log"
        wait_for(lambda: log.exists() and "has claim" in log.read_text("utf-8"), "it runs", 120.0)
        first.send_signal(signal.SIGKILL)
    wait_for(lambda: not processes_in(out), "no process is left")

    done = fairlead("demo", "--gif", "--out", str(out), state=registry)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "G020 limit" in done.stderr and "G004 " in done.stderr

    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert (summary["outcome"], summary["decided_by"]) == ("succeeded", "task")
    assert summary["pacing"] == "lockstep" and summary["ticks"] > 100
    assert summary["verdicts"] == {"released": summary["policy_calls"]}
    assert [one["code"] for one in summary["challenges"]] == ["G020", "G004"]
    # What is replayed is the finished goal's chunk, not the one that the demo made up after it.
    assert f"chunk {summary['policy_calls']} refused" in summary["challenges"][1]["reason"]
    assert (out / "timeline.png").read_bytes().startswith(b"\x89PNG")
    again = tmp_path / "again.png"
    drawn = fairlead("plot", str(out), "--ticks", "70:150", "--out", str(again), state=tmp_path)
    assert drawn.stdout == f"{again}: ticks 70 to 150 of {out}\n", drawn.stderr
    assert again.read_bytes().startswith(b"\x89PNG")
    if "video" not in summary:  # the machine can render
        assert (out / "demo.gif").read_bytes().startswith(b"GIF89a")
        assert b"ftyp" in (out / "demo.mp4").read_bytes()[:16]
    assert processes_in(out) == []


@pytest.mark.thorough
def test_a_demo_whose_service_dies_in_the_middle_names_it_with_its_last_lines(
    tmp_path: Path,
) -> None:
    out = tmp_path / "demo"
    with subprocess.Popen(
        fairlead_command("demo", "--no-video", "--out", str(out)),
        env=fairlead_environment(tmp_path / "registry"),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as demo:
        log = out / "state" / "logs" / "runner.log"
        wait_for(lambda: log.exists() and "has claim" in log.read_text("utf-8"), "it runs", 120.0)
        hal = pids_that_mention(out / "state" / "hal")[0]
        os.kill(hal, signal.SIGKILL)
        _, said = demo.communicate(timeout=120.0)
    assert demo.returncode == 1 and "Traceback" not in said
    assert "hal: was killed by signal 9; its last lines (" in said
    assert "then try again: fairlead demo" in said
    assert processes_in(out) == []


def test_a_demo_whose_service_cannot_start_names_it_its_last_lines_and_the_next_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "mujoco.py").write_text("raise ImportError('no such library')", encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(broken))
    out = tmp_path / "demo"
    done = fairlead("demo", "--no-video", "--out", str(out), state=tmp_path / "registry")
    assert done.returncode == 1
    assert f"hal: ended with status 1; its last lines ({out}/state/logs/hal.log):" in done.stderr
    assert "  [hal] ImportError: no such library" in done.stderr
    assert f"fairlead logs --state-dir {out / 'state'}" in done.stderr
    assert "then try again: fairlead demo" in done.stderr
    assert processes_in(out) == []
