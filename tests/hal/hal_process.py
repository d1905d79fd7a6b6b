"""Starts a HAL, by default the one without physics, as a real process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

import yaml

from bench.equipment.live_robot import wait_for
from fairlead.deploy.deployment import Deployment
from fairlead.wire.bus import Sample
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports

START_S = 120.0
"""A simulator and its renderer take tens of seconds to start on a busy machine."""

_NUMBERS = count()


class HalProcess:
    """One HAL process in its own folder, and a bus that reaches it."""

    def __init__(
        self, folder: Path, pacing: str, run: str = "hal_kinematic", **options: Any
    ) -> None:
        self.folder = folder
        self.state_dir = folder / "state"
        self.state_dir.mkdir(exist_ok=True)
        self.spec: dict[str, Any] = {
            "robot": "panda_mobile",
            "id": f"tested{os.getpid()}_{next(_NUMBERS)}",
            "pacing": pacing,
            "access": "open",  # one session is everybody but the HAL
            "services": {
                "hal": {
                    "run": run,
                    "listen": f"tcp/127.0.0.1:{free_ports(1)[0]}",
                    "options": options,
                }
            },
        }
        self.deployment = Deployment.model_validate(self.spec)
        self.keys = self.deployment.keys
        self.log = folder / "hal.log"
        self.process = self.launch(self.spec, self.state_dir, self.log)
        try:
            self.wait_until(lambda: "ready" in self.log.read_text(), "the HAL to be ready", START_S)
        except AssertionError:
            self.process.kill()
            self.process.wait()
            raise
        self.bus = ZenohBus(self.deployment.tool_endpoints())

    def launch(self, spec: dict[str, Any], state_dir: Path, log: Path) -> subprocess.Popen[bytes]:
        path = log.with_suffix(".yaml")
        path.write_text(yaml.safe_dump(spec))
        command = [sys.executable, "-m", "fairlead.hal.serve", "--deployment", str(path)]
        command += ["--service", "hal", "--state-dir", str(state_dir)]
        with log.open("wb") as output:
            return subprocess.Popen(
                command,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
            )

    def motion(self) -> list[dict[str, Any]]:
        """Whole lines of motion.jsonl so far."""
        text = (self.state_dir / "motion.jsonl").read_text()
        return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]

    def collect(self, key: str, count: int) -> list[Sample]:
        """The next samples on a key expression."""
        samples: list[Sample] = []
        enough = threading.Event()

        def on_sample(sample: Sample) -> None:
            samples.append(sample)
            if len(samples) >= count:
                enough.set()

        subscription = self.bus.subscribe(key, on_sample)
        assert enough.wait(20.0), f"{len(samples)} of {count} samples on {key}"
        subscription.undeclare()
        return samples[:count]

    def wait_until(self, condition: Callable[[], bool], what: str, timeout_s: float = 30.0) -> None:
        def holds() -> bool:
            assert self.process.poll() is None, f"the HAL ended: {self.log.read_text()}"
            return condition()

        wait_for(holds, what, timeout_s)

    def close(self) -> None:
        self.bus.close()
        if self.process.poll() is None:
            self.process.terminate()
        assert self.process.wait(timeout=20) in (0, -9), self.log.read_text()
