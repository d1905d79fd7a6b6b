"""The light robot, with a policy behind a server of its own that can be told to misbehave."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from bench.equipment.live_robot import wait_for
from bench.equipment.turning import TurningBase
from bench.faults.live_stage import SKILL, LiveStage, live_stage
from bench.faults.policy_server import ANSWER_TIMEOUT_S, ROWS

SERVED = "served-motion"


class ServerProcess:
    """The server's process.

    said: each thing it did and when (CLOCK_MONOTONIC [ns]), the first is its address.
    """

    def __init__(self) -> None:
        words = [sys.executable, "-m", "bench.faults.policy_server"]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True)
        self.said: list[tuple[str, int]] = []
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()
        wait_for(lambda: bool(self.said), "the policy server listens")
        self.address = self.said[0][0]

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            entry = json.loads(line)
            self.said.append((entry["what"], entry["at_ns"]))

    def behave(self, behaviour: str) -> int:
        """From now on; when [ns], and no later than this takes effect."""
        now_ns, known = time.monotonic_ns(), len(self.said)
        assert self._process.stdin is not None
        self._process.stdin.write(f"{behaviour}\n")
        self._process.stdin.flush()
        wait_for(
            lambda: any(what.startswith("from now on") for what, _ in self.said[known:]),
            f"the policy server is told to be {behaviour}",
        )
        return now_ns

    def when(self, what: str, since_ns: int) -> int:
        """The first time it did this; waits for it."""
        found: list[int] = []

        def did() -> bool:
            found[:] = [at for name, at in list(self.said) if name == what and at >= since_ns]
            return bool(found)

        wait_for(did, f"the policy server did: {what}")
        return found[0]

    def close(self) -> None:
        """End it."""
        with self._process:
            self._process.kill()
            self._listener.join()


class PolicyStage(LiveStage):
    """server: of the skill's policy. base: what it was told and did."""

    server: ServerProcess
    base: TurningBase


def served_skill(folder: Path, address: str) -> None:
    """The steady skill again, with its policy behind a server."""
    manifest: dict[str, Any] = yaml.safe_load((folder / SKILL / "rskill.yaml").read_text())
    manifest |= {
        "id": SERVED, "horizon": ROWS, "execute_steps": ROWS // 2, "age_max_ticks": 10,
        "policy": {
            "backend": "openpi",
            "options": {
                "address": address, "start": "python -m bench.faults.policy_server",
                "connect_timeout_s": 4.0, "answer_timeout_s": ANSWER_TIMEOUT_S,
            },
        },
    }  # fmt: skip
    (folder / SERVED).mkdir()
    text = yaml.safe_dump(manifest)
    (folder / SERVED / "rskill.yaml").write_text(text, encoding="utf-8")


@contextmanager
def policy_stage(folder: Path) -> Iterator[PolicyStage]:
    """All services and the server, which behaves."""
    with live_stage(folder) as robot:
        server = ServerProcess()
        try:
            served_skill(folder / "skills", server.address)
            stage = PolicyStage(robot.robot, SERVED)
            stage.server, stage.base = server, TurningBase(stage.client.bus, stage.client.keys)
            yield stage
        finally:
            server.close()
