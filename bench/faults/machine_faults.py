"""Clock, disk, files and onlookers: what must not matter to a robot in motion."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

from bench.equipment.live_robot import wait_for
from bench.faults.failing_disk import DiskStage
from bench.faults.flood import FLOODS, WITH_RIGHTS
from bench.faults.live_stage import SKILL, LiveStage
from bench.faults.machine_stage import MachineStage
from bench.faults.row import Row, Shot
from bench.faults.stop_faults import STOP_MS
from fairlead.errors import RefusedError

HOUR_S = 3600
WATCHED_NS = 10**9
FLOOD_NS = 4 * WATCHED_NS  # connections that say nothing are closed after two seconds
FSYNC_MS = 2000
READ_ONLY = "Read-only file system"


def wall_clock(robot: MachineStage) -> Shot:
    goal = robot.start_moving()
    injected_ns, ticks = time.monotonic_ns(), 0
    for shift_s in (HOUR_S, -HOUR_S):
        now_ns = robot.tamper(wall_shift_s=shift_s)
        ticks += robot.no_hold_between(now_ns, now_ns + WATCHED_NS)
        assert abs(robot.wall_clock() - time.time() - shift_s) < 60, "the clock did not change"
    ended_ns = robot.tamper()
    robot.finish(goal)
    return Shot(None, injected_ns, ended_ns, note=f"{ticks} ticks, none held")


def changed_files(robot: MachineStage) -> Shot:
    """The gate's file, robot.yaml and rskill.yaml change while rows act."""
    files = (
        robot.tree / "robots" / "panda_mobile" / "gate.sim.json",
        robot.tree / "robots" / "panda_mobile" / "robot.yaml",
        robot.tree.parent / "skills" / SKILL / "rskill.yaml",
    )
    before = {file: file.read_bytes() for file in files}
    goal = robot.start_moving()
    injected_ns = time.monotonic_ns()
    try:
        for file in files:
            file.write_bytes(before[file] + b"\n")
        ticks = robot.no_hold_between(injected_ns, injected_ns + WATCHED_NS)
        robot.finish(goal)
        refused_ns = time.monotonic_ns()
        refusal = arm_refused(robot)
        assert "configuration file has changed" in refusal, refusal
        taken_ms = (time.monotonic_ns() - refused_ns) / 1e6
    finally:
        for file, content in before.items():
            file.write_bytes(content)
    robot.client.arm()
    return Shot(taken_ms, injected_ns, refused_ns, note=f"{ticks} ticks, none held; {refusal}")


def arm_refused(robot: LiveStage) -> str:
    """What the gate says instead of arming."""
    try:
        robot.client.arm()
    except RefusedError as error:
        return error.reason
    raise AssertionError("armed with files that changed")


def full_disk(robot: MachineStage) -> Shot:
    goal = robot.start_moving()
    injected_ns = time.monotonic_ns()
    filler = robot.disk / "filler"
    try:
        fill(filler)
        ticks = robot.no_hold_between(injected_ns, injected_ns + 2 * WATCHED_NS)
        log = robot.supervisor.state_dir / "logs" / "safety.log"
        wait_for(lambda: "No space left" in log.read_text(), "the gate says that its disk is full")
    finally:
        filler.unlink(missing_ok=True)
    said = [line for line in log.read_text().splitlines() if "No space left" in line][-1]
    robot.finish(goal)
    return Shot(None, injected_ns, time.monotonic_ns(), note=f"{ticks} ticks, none held; {said}")


def fill(file: Path) -> None:
    """Write until the disk is full."""
    with file.open("wb", buffering=0) as stream:
        try:
            while stream.write(bytes(4096)):
                pass
        except OSError:
            return


def read_only_disk(stage: DiskStage) -> Shot:
    """The disk fails in motion; then an operator's stop, which cannot be written down either."""
    with stage.robot() as (robot, disk):
        goal = robot.start_moving()
        failed_ns = time.monotonic_ns()
        disk.fail()
        ticks = robot.no_hold_between(failed_ns, failed_ns + 2 * WATCHED_NS)
        log = robot.supervisor.state_dir / "logs" / "safety.log"
        wait_for(lambda: READ_ONLY in log.read_text(), "the gate says that its disk is read-only")
        said = next(line for line in log.read_text().splitlines() if READ_ONLY in line)
        injected_ns = time.monotonic_ns()
        robot.client.stop("test")
        shot = robot.hold_shot(injected_ns, f"{ticks} ticks, none held; {said}")
        robot.ended(goal)
        return shot


def slow_disk(robot: MachineStage) -> Shot:
    """A stop while every fsync takes seconds: it is said before it is written down."""
    goal = robot.start_moving()
    injected_ns = robot.tamper(fsync_ms=FSYNC_MS)
    try:
        robot.client.stop("test")
        shot = robot.hold_shot(injected_ns)
    finally:
        robot.tamper()
    robot.ended(goal)
    return shot


def onlooker(end: signal.Signals, robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    words = [sys.executable, "-m", "bench.faults.slow_reader", str(robot.robot.scratch.file)]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as reader:
        try:
            assert reader.stdout is not None and reader.stdout.readline() == b"ready\n"
            injected_ns = time.monotonic_ns()
            ticks = robot.no_hold_between(injected_ns, injected_ns + WATCHED_NS)
            reader.send_signal(end)
            now_ns = time.monotonic_ns()
            ticks += robot.no_hold_between(now_ns, now_ns + 2 * WATCHED_NS)
        finally:
            reader.kill()
    robot.finish(goal)
    return Shot(None, injected_ns, time.monotonic_ns(), note=f"{ticks} ticks, none held")


def flooded(kind: str, robot: LiveStage) -> Shot:
    goal = robot.start_moving()
    words = [sys.executable, "-m", "bench.faults.flood", str(robot.robot.scratch.file), kind]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as flood:
        try:
            assert flood.stdout is not None and flood.stdout.readline() == b"ready\n"
            injected_ns = time.monotonic_ns()
            ticks = robot.no_hold_between(injected_ns, injected_ns + FLOOD_NS)
        finally:
            flood.kill()
    robot.finish(goal)
    return Shot(None, injected_ns, time.monotonic_ns(), note=f"{ticks} ticks, none held")


NO_EFFECT = "no tick is held"
ROWS = (
    Row(18, "wall clock of every service + 1 h, then - 1 h", NO_EFFECT, None, "machine",
        wall_clock),
    Row(31, "gate file, robot.yaml and rskill.yaml change while armed",
        f"{NO_EFFECT}; the next arm is refused by hash", 1000, "machine", changed_files,
        "the refusal"),
    Row(32, "disk of gate and runner full", f"{NO_EFFECT}; the gate's log says so", None,
        "machine", full_disk),
    Row(32, "disk of gate and runner read-only, then a stop",
        f"{NO_EFFECT}; the stop stops", STOP_MS, "disk", read_only_disk,
        "stop to hold", 5),
    Row(32, f"stop while each fsync takes {FSYNC_MS / 1e3:g} s", "stops", STOP_MS, "machine",
        slow_disk, "stop to hold", 5),
    Row(33, "a slow reader hangs", NO_EFFECT, None, "robot",
        partial(onlooker, signal.SIGSTOP)),
    Row(33, "a slow reader is killed", NO_EFFECT, None, "robot",
        partial(onlooker, signal.SIGKILL)),
    Row(33, "1,200 silent connections to the services", NO_EFFECT, None, "robot",
        partial(flooded, "connections")),
    Row(33, "six programs that query the status without pause", NO_EFFECT, None, "robot",
        partial(flooded, "queries")),
    *(
        Row(33, f"flood of {kind}", NO_EFFECT, None,
            "robot" if kind in WITH_RIGHTS else "open", partial(flooded, kind))
        for kind in FLOODS if kind not in ("connections", "queries")
    ),
)  # fmt: skip
