"""Receipts: what the gate was given and decided is on disk, and judged again it is the same."""

from __future__ import annotations

import json
import resource
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fairlead.bus import Qos
from fairlead.keys import Keys
from fairlead.messages import GateState, Outcome, StopLevel, pack_floats
from fairlead.paths import gate_binary, gate_config
from fairlead.session import Endpoints, ZenohBus
from tests.gate.mailbox import DEADLINE_S
from tests.gate.running_gate import ROBOT, RunningGate
from tests.gate.scene import Scene

pytestmark = pytest.mark.processes


def judge(*words: object) -> tuple[int, dict[str, Any]]:
    """Exit status and document of ``fairlead-safety judge``."""
    done = subprocess.run(
        [str(gate_binary()), "judge", *map(str, words), "--json"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    return done.returncode, json.loads(done.stdout) if done.stdout.startswith("{") else {}


def judged_text(*words: object) -> tuple[int, str]:
    done = subprocess.run(
        [str(gate_binary()), "judge", *map(str, words)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    return done.returncode, done.stdout


def logs(scene: Scene) -> list[Path]:
    return sorted((scene.state_dir / "decisions").glob("*.decisions"))


def moves(scene: Scene, step_m: float, rows: int = 4) -> Any:
    """A chunk whose rows all move the arm by ``step_m`` along x."""
    values = np.zeros((rows, 6))
    values[:, 0] = step_m
    return scene.chunk(rows, parts=(scene.arm_part(rows, values=pack_floats(values)),))


def drive(scene: Scene, steps: tuple[float, ...]) -> list[Outcome]:
    """One chunk per step width; what is released is executed to its last row."""
    outcomes = []
    for step_m in steps:
        verdict = scene.send(moves(scene, step_m))
        outcomes.append(Outcome(verdict.outcome))
        if verdict.outcome == Outcome.REFUSED:
            scene.next_tick()
            continue
        for row in range(verdict.released_last - verdict.released_first + 1):
            scene.acted_on(verdict, row)
    return outcomes


def tightened(config: Path, tmp_path: Path, linear_limit: float) -> Path:
    file = json.loads(config.read_text())
    file["parts"][0]["modes"]["cartesian_delta"]["linear_limit"] = linear_limit
    path = tmp_path / "tighter.json"
    path.write_text(json.dumps(file))
    return path


@pytest.fixture
def a_run(scene: Scene) -> Path:
    """The log of a run with good chunks, bad ones, a stop and a reset; the gate has ended."""
    scene.ready_to_move()
    assert drive(scene, (0.01, 0.05, 0.09, 0.02, 0.06)) == [0, 0, 2, 0, 0]
    scene.send_bytes(b"\xc1")
    scene.send(moves(scene, float("nan")))
    stopped = scene.wait_state(GateState.STOPPED)
    scene.reset(stopped.stop_ids[0])
    scene.silence()
    assert scene.gate.stop() == 0
    return logs(scene)[-1]


def test_a_run_judged_again_is_identical_bit_for_bit(a_run: Path) -> None:
    status, found = judge(a_run)
    assert (status, found["identical"]) == (0, True), found
    assert found["read"] == "complete: the gate ended on request"
    assert (found["released"], found["refused"], found["lost"]) == (4, 3, 0)


def test_a_tighter_limit_names_exactly_the_chunks_it_would_have_refused(
    a_run: Path, config: Path, tmp_path: Path
) -> None:
    status, found = judge(a_run, "--config", tightened(config, tmp_path, 0.03))
    changes = [
        (c["recorded"]["seq"], c["recorded"]["outcome"], c["instead"]["outcome"])
        for c in found["changed"]
    ]
    assert (status, changes) == (1, [(2, "released", "refused"), (5, "released", "refused")])
    instead = found["changed"][0]["instead"]
    assert (instead["code"], instead["part"], instead["axis"]) == (20, "arm", "linear")
    assert (instead["value"], instead["limit"]) == (pytest.approx(0.05), 0.03)
    assert (found["unjudged"], found["notes"]) == (0, [])


def test_the_same_limits_under_another_name_change_nothing(
    a_run: Path, config: Path, tmp_path: Path
) -> None:
    status, found = judge(a_run, "--config", tightened(config, tmp_path, 0.0867))
    assert (status, found["changed"], found["unjudged"]) == (0, [], 0)


def test_chunks_of_a_claim_that_would_have_been_refused_are_counted_not_judged(
    a_run: Path, config: Path, tmp_path: Path
) -> None:
    file = json.loads(config.read_text())
    file["protocol"]["chunk_rate_max_hz"] = 10.0
    (tmp_path / "slower.json").write_text(json.dumps(file))
    status, found = judge(a_run, "--config", tmp_path / "slower.json")
    assert (status, found["changed"], found["unjudged"]) == (1, [], 6), found
    assert found["notes"][0].startswith("tick 1: refused a query: "), found["notes"]
    assert found["open_loop"].startswith("open loop: states are as recorded")


def test_a_log_is_not_judged_under_the_limits_of_another_robot(a_run: Path) -> None:
    other = gate_config("panda", "sim")
    assert judged_text(a_run, "--config", other) == (
        2,
        f"ERROR fairlead-safety: judge: the log is of the robot panda_mobile, {other} of panda\n",
    )


def test_judge_says_in_words_what_changes(a_run: Path, config: Path, tmp_path: Path) -> None:
    status, text = judged_text(a_run, "--config", tightened(config, tmp_path, 0.03))
    assert status == 1
    assert [line for line in text.splitlines() if line.startswith("  tick")] == [
        "  tick 5: chunk 2 of runner was released; instead: chunk 2 of runner refused: G020 arm "
        "linear, row 0: 0.05, limit 0.03 (robosuite OSC_POSE output_max 0.05 m and 0.5 rad on all "
        "three axes at once; steps admit a full reversal)",
        "  tick 14: chunk 5 of runner was released; instead: chunk 5 of runner refused: G020 arm "
        "linear, row 0: 0.06, limit 0.03 (robosuite OSC_POSE output_max 0.05 m and 0.5 rad on all "
        "three axes at once; steps admit a full reversal)",
    ]
    assert "2 of 7 verdicts change\n" in text


def test_a_changed_byte_is_found_wherever_it_is(a_run: Path, tmp_path: Path) -> None:
    original = a_run.read_bytes()
    for place in np.linspace(0, len(original) - 1, 40).astype(int):
        damaged = bytearray(original)
        damaged[place] ^= 0x10
        copy = tmp_path / "damaged.decisions"
        copy.write_bytes(damaged)
        status, found = judge(copy)
        assert status == 2, (place, found)


def test_a_log_cut_off_anywhere_is_judged_up_to_there(a_run: Path, tmp_path: Path) -> None:
    original = a_run.read_bytes()
    header = original.index(b"\x02", original.rindex(b'"started"'))
    for place in np.linspace(header + 200, len(original) - 1, 20).astype(int):
        copy = tmp_path / "cut.decisions"
        copy.write_bytes(original[:place])
        status, found = judge(copy)
        assert (status, found["identical"]) == (0, True), (place, found)
        assert not found["read"].startswith("complete")


def wait_until_recorded(path: Path, **counts: int) -> dict[str, Any]:
    """Until the log of a running gate says so: its writer is a moment behind the decisions."""
    deadline = time.monotonic() + DEADLINE_S
    while True:
        status, found = judge(path)
        assert status == 0, found
        if all(found[name] == count for name, count in counts.items()):
            return found
        assert time.monotonic() < deadline, f"expected {counts}, the log has {found}"


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


def test_only_the_newest_runs_are_kept(config: Path, tmp_path: Path) -> None:
    for _ in range(4):
        gate = RunningGate(config, tmp_path / "state", "--decision-log-runs", "2")
        gate.wait_line("ready")
        assert gate.stop() == 0
    kept = sorted(path.name for path in (tmp_path / "state" / "decisions").iterdir())
    assert kept == ["000003.decisions", "000004.decisions"]


def test_a_log_at_its_size_limit_ends_there_and_says_so(config: Path, tmp_path: Path) -> None:
    folder = tmp_path / "state" / "decisions"
    gate = RunningGate(config, tmp_path / "state", "--decision-log-mib", "1")
    gate.wait_line("ready")
    bus = ZenohBus(Endpoints(connect=[f"tcp/127.0.0.1:{gate.port}"]))
    stops = bus.publisher(Keys(ROBOT).stop, StopLevel, Qos.HOT)
    alive = threading.Event()
    bus.watch_tokens(Keys(ROBOT).alive("safety"), lambda key, is_alive: alive.set())
    assert alive.wait(DEADLINE_S)
    for _ in range(40):  # no stop levels, but recorded as they came
        stops.put_bytes(bytes(60_000))
    assert gate.wait_line("size limit") == (
        f"WARNING safety: decision log: {folder}/000001.decisions has reached its size limit: "
        "nothing more is recorded"
    )
    bus.close()
    assert gate.stop() == 0
    assert (folder / "000001.decisions").stat().st_size <= 1 << 20
    status, found = judge(folder)
    assert (status, found["read"]) == (0, "complete: the log reached its size limit")


def test_every_run_has_a_log_and_a_folder_means_its_newest(scene: Scene) -> None:
    scene.gate.stop()
    scene.restart_gate()
    scene.gate.stop()
    assert [path.name for path in logs(scene)] == ["000001.decisions", "000002.decisions"]
    status, found = judge(scene.state_dir / "decisions")
    assert (status, found["log"]) == (0, str(logs(scene)[-1]))


def test_what_is_no_log_is_refused_by_name(tmp_path: Path) -> None:
    status, text = judged_text(tmp_path)
    assert (status, text) == (
        2,
        f"ERROR fairlead-safety: decision log: no *.decisions in the folder {tmp_path}\n",
    )
    (tmp_path / "other").write_text("fairlead-decisions-2\n")
    status, text = judged_text(tmp_path / "other")
    assert (status, text) == (
        2,
        f"ERROR fairlead-safety: decision log {tmp_path}/other: expected its first line to be "
        "fairlead-decisions-1\n",
    )
