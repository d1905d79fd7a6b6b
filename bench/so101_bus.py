"""How regular the ticks of an SO-101 are: six emulated servos at the bus's byte rate, 50 Hz.

    .venv/bin/python -m bench.so101_bus [--seconds 60] [--priority 50]

First the HAL's backend alone: how long one read of all servos and one write takes. Then a whole
deployment, with a goal in it: jitter is how far the time between two of the HAL's decisions, each
after a read, is from the period. With --priority the emulator, and in the deployment the HAL, have
that real-time priority: a real bus waits for no other process.
"""

from __future__ import annotations

import argparse
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

from bench.equipment.emulated_arm import emulated_arm
from bench.equipment.motion_log import MotionLog
from fairlead.deploy.scheduling import realtime_words
from fairlead.messages import FloatArray
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead.robot.manifest import load_robot
from fairlead_hal_so101.calibration import Arm, CalibratedServo, Calibration, save_calibration
from fairlead_hal_so101.options import So101Options
from fairlead_hal_so101.so101_backend import So101Backend
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot

ROBOT = load_robot("so101")
SKILL = "so101-reach"
PERIOD_MS = 20.0
READS = 500


def calibration(path: Path, arm: Arm = "follower") -> Calibration:
    """Of servos that are mounted as the guide says."""
    found = tuple(
        CalibratedServo(
            joint=name, id=one, homing_offset_steps=0, direction=1, lower_steps=0, upper_steps=4095
        )
        for one, name in enumerate(ROBOT.joint_names, start=1)
    )
    known = Calibration(robot="so101", arm=arm, servos=found)
    save_calibration(path, known)
    return known


def alone(options: So101Options, known: Calibration) -> tuple[FloatArray, FloatArray]:
    """Times of reads and of writes [ms]."""
    backend, pause = So101Backend(ROBOT, "sim", options, known), threading.Event()
    read, write = [], []
    for _ in range(READS):
        began = time.perf_counter()
        backend.read()
        measured = time.perf_counter()
        backend.apply({})
        read.append(measured - began)
        write.append(time.perf_counter() - measured)
        pause.wait(PERIOD_MS / 1e3)
    backend.close()
    return np.array(read) * 1e3, np.array(write) * 1e3


def deployed(options: So101Options, folder: Path, seconds: float, priority: int) -> FloatArray:
    """Jitter of every tick [ms], of which some seconds with a goal."""
    scratch = make_scratch(
        repo_root() / "compose" / "so101_mujoco.yaml",
        folder / "state",
        ScratchOptions(
            hal={
                "run": "hal_so101",
                "options": options.model_dump(mode="json"),
                "realtime_priority": priority,
            },
            options={"runner": {"skills": [SKILL]}},
        ),
    )
    with scratch_robot(scratch) as robot:
        log, began_ns = MotionLog(scratch.state_dir / "hal"), time.monotonic_ns()
        robot.client.arm()
        result = run_goal(robot.client, GoalOptions(SKILL, deadline_ticks=1500)).result
        assert result is not None and result.outcome == "succeeded", result
        threading.Event().wait(seconds - (time.monotonic_ns() - began_ns) / 1e9)
        stamps = [line.stamp_ns for line in log.since(began_ns)]
    return np.asarray(np.abs(np.diff(stamps) / 1e6 - PERIOD_MS))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m bench.so101_bus")
    parser.add_argument("--seconds", type=float, default=60.0, help="of the deployment")
    parser.add_argument("--priority", type=int, default=0, help="of SCHED_FIFO; 0: none")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        port, file = folder / "arm" / "so101", folder / "arm.yaml"
        options, known = So101Options(port=str(port), calibration=str(file)), calibration(file)
        before = realtime_words("emulator", arguments.priority)
        with emulated_arm(port.parent, before=before):
            read, write = alone(options, known)
        with emulated_arm(port.parent, before=before):
            jitter = deployed(options, folder, arguments.seconds, arguments.priority)
    for what, times in (("read", read), ("write", write), ("jitter", jitter)):
        middle, p99, most = np.percentile(times, [50, 99, 100])
        print(f"{what}: median {middle:.2f}, p99 {p99:.2f}, most {most:.2f} ms ({len(times)})")


if __name__ == "__main__":
    main()
