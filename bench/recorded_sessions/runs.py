"""Real runs of real gates whose decision logs become recorded sessions."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from bench.equipment.real_gate import LOGS

TESTS = (
    "tests/explorer",
    "tests/gate",
    "tests/hal_mujoco/test_joint_reach.py",
    "tests/system/test_modes.py",
    "tests/system/test_modes_mobile.py",
    "tests/system/test_injected_chunks.py",
    "tests/system/test_first_skill.py",
)
FAULTS = (1, 2, 4, 5, 14, 19, 21, 22, 26, 28, 35, 36, 37)


def run_everything(folder: Path) -> None:
    """The shipped demo, tests with real gates, the explorer, and faults; logs lie in ``folder``.

    A test or a fault that fails is named and its log used all the same: it happened.
    """
    python, fairlead = sys.executable, str(Path(sys.executable).with_name("fairlead"))
    explorer = folder / "explorer"
    explorer.mkdir(parents=True)
    environment = dict(os.environ, **{LOGS: str(explorer), "FAIRLEAD_STATE": str(folder / "state")})
    commands = [
        [fairlead, "demo", "--no-video", "--out", str(folder / "demo")],
        [python, "-m", "pytest", "-q", f"--basetemp={folder / 'pytest'}", *TESTS],
        [python, "-m", "bench.faults", "--injections", "1", "--logs", str(folder / "faults")],
    ]
    for number in FAULTS:
        commands[-1] += ["--row", str(number)]
    (folder / "faults").mkdir()
    for command in commands:
        print("sessions:", *command, file=sys.stderr, flush=True)
        done = subprocess.run(command, env=environment, check=False)
        if done.returncode:
            print(f"sessions: {command[:3]} ended with {done.returncode}", file=sys.stderr)
