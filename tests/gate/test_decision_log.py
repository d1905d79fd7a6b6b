"""The decision log: what the gate was given and decided is on disk, whatever the disk does."""

from __future__ import annotations

import resource
import threading
import time
from pathlib import Path

import pytest

from bench.equipment.gate_scene import Scene
from bench.equipment.mailbox import DEADLINE_S
from bench.equipment.running_gate import ROBOT, RunningGate
from fairlead.keys import Keys
from fairlead.messages import GateState, Outcome, StopLevel
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from tests.gate.decision_logs import (
    drive,
    judge,
    logs,
    wait_until_recorded,
)

pytestmark = pytest.mark.processes


def test_the_log_of_a_killed_gate_is_usable(scene: Scene) -> None:
    scene.ready_to_move()
    drive(scene, (0.01, 0.09))
    wait_until_recorded(logs(scene)[-1], released=1, refused=1)
    scene.gate.kill()
    status, found = judge(logs(scene)[-1])
    assert (status, found["identical"], found["released"]) == (0, True, 1), found
    assert not found["read"].startswith("complete")


def test_a_full_disk_leaves_control_alone_and_the_log_names_the_gap(scene: Scene) -> None:
    scene.ready_to_move()
    log = logs(scene)[-1]
    drive(scene, (0.01,))
    wait_until_recorded(log, released=1)
    pid = scene.gate.process.pid
    size = log.stat().st_size + 100
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    assert drive(scene, (0.02,) * 5) == [Outcome.RELEASED] * 5
    line = scene.gate.wait_line("decision log: ")
    assert line == (
        f"WARNING safety: decision log: cannot write {log}: File too large; "
        "decisions are not recorded until it can be"
    )
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
    line = scene.gate.wait_line("decision log: ")
    assert line == "WARNING safety: decision log: can be written again; the log names the gap"
    drive(scene, (0.02,))
    assert scene.status().state == GateState.ARMED
    scene.silence()
    assert scene.gate.stop() == 0
    status, found = judge(log)
    assert (status, found["identical"], found["released"]) == (0, True, 1), found
    assert found["read"] == (
        f"judged up to a gap of {found['lost']} records that could not be written"
    )


def test_a_gate_that_cannot_write_its_log_starts_and_says_so_once(
    config: Path, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("in the way")
    gate = RunningGate(config, tmp_path / "state", "--decision-log", str(tmp_path / "file" / "log"))
    gate.wait_line("ready")
    assert gate.stop() == 0
    assert [line for line in gate.lines if "decision log" in line] == [
        f"WARNING safety: decision log: cannot write {tmp_path}/file/log/000001.decisions: "
        "Not a directory; nothing is recorded in this run"
    ]


def test_a_log_that_nobody_wants_is_not_kept(config: Path, tmp_path: Path) -> None:
    gate = RunningGate(config, tmp_path / "state", "--decision-log", "none")
    gate.wait_line("ready")
    assert gate.stop() == 0
    assert not (tmp_path / "state" / "decisions").exists()


def test_only_the_newest_files_are_kept(config: Path, tmp_path: Path) -> None:
    for _ in range(4):
        gate = RunningGate(config, tmp_path / "state", "--decision-log-files", "2")
        gate.wait_line("ready")
        assert gate.stop() == 0
    kept = sorted(path.name for path in (tmp_path / "state" / "decisions").iterdir())
    assert kept == ["000003.decisions", "000004.decisions"]


def test_junk_pushes_out_the_oldest_files_and_the_log_goes_on(config: Path, tmp_path: Path) -> None:
    folder = tmp_path / "state" / "decisions"
    gate = RunningGate(config, tmp_path / "state", "--decision-log-mib", "1")
    gate.wait_line("ready")
    bus = ZenohBus(Endpoints(connect=[f"tcp/127.0.0.1:{gate.port}"]))
    stops = bus.publisher(Keys(ROBOT).stop, StopLevel, Qos.HOT)
    alive = threading.Event()
    bus.watch_tokens(Keys(ROBOT).alive("safety"), lambda key, is_alive: alive.set())
    assert alive.wait(DEADLINE_S)
    gives_up = time.monotonic() + DEADLINE_S
    while (folder / "000001.decisions").exists() and time.monotonic() < gives_up:
        stops.put_bytes(bytes(60_000))  # no stop levels, but recorded as they came
        time.sleep(0.002)  # the pace of the junk: more at once would be dropped on the way
    stops.put(StopLevel(stop_id=77, by="operator", reason="after the junk"))
    gate.wait_line("stop")
    bus.close()
    assert gate.stop() == 0
    files = sorted(folder.iterdir())
    assert files[0].name != "000001.decisions"
    assert sum(file.stat().st_size for file in files) <= 1 << 20
    assert b"after the junk" in b"".join(file.read_bytes() for file in files[-2:])
    status, found = judge(folder)
    assert (status, found["identical"], found["steps"]) == (2, False, 0)
    assert found["read"].startswith("nothing judged: it goes on from a file before")


def test_every_run_has_a_log_and_a_folder_means_its_newest(scene: Scene) -> None:
    scene.gate.stop()
    scene.restart_gate()
    scene.gate.stop()
    assert [path.name for path in logs(scene)] == ["000001.decisions", "000002.decisions"]
    status, found = judge(scene.state_dir / "decisions")
    assert (status, found["log"]) == (0, str(logs(scene)[-1]))
