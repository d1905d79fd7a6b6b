"""``fairlead up`` of a light robot in the background, and commands about it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import threading
from pathlib import Path
from typing import Any

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import wait_for
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import Scratch, ScratchOptions, make_scratch
from tests.cli.command import fairlead_command, fairlead_environment, fairlead_here
from tests.cli.process_list import pids_that_mention

SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"


class Up:
    """``fairlead up`` in the background, and what it prints."""

    def __init__(self, scratch: Scratch, state: Path) -> None:
        self.scratch, self.state = scratch, state
        self.name = scratch.deployment.id
        self.output: list[str] = []
        self.process = subprocess.Popen(
            fairlead_command("up", str(scratch.file), "--state-dir", str(scratch.state_dir)),
            env=fairlead_environment(state),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as stream:
            self.output.extend(line.rstrip() for line in stream)

    def wait_line(self, text: str) -> str:
        wait_for(lambda: any(text in line for line in self.output), f"up prints {text!r}", 120.0)
        return next(line for line in self.output if text in line)

    def do(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Another ``fairlead`` command about this robot."""
        return fairlead_here(*arguments, state=self.state)

    def read(self, *arguments: str) -> Any:
        done = fairlead_here(*arguments, "--json", state=self.state)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    def processes(self) -> list[int]:
        """Processes of this deployment's folder, without ``up`` itself."""
        return [pid for pid in pids_that_mention(self.scratch.state_dir) if pid != self.process.pid]

    def end(self, number: signal.Signals) -> int:
        self.process.send_signal(number)
        status = self.process.wait(timeout=30.0)
        self._reader.join(timeout=5.0)
        return status


def started_in(folder: Path, name: str) -> Up:
    options = ScratchOptions(f"{name}{os.getpid()}", hal=LIGHT_HAL)
    return Up(make_scratch(SOURCE, folder / name, options), folder / "registry")


def end(up: Up) -> None:
    if up.process.poll() is None:
        up.end(signal.SIGKILL)
    wait_for(lambda: not up.processes(), "no process is left")
