"""Programs of the ROS 2 side as processes, and the Panda as it is there."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bench.equipment.live_robot import wait_for
from tests.repo.tree import ROOT

START = [0.0, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785]
JOINTS = {f"joint{number + 1}": value for number, value in enumerate(START)}
FINGERS = {"left_finger": 0.04, "right_finger": 0.04}
NAMES = {
    **{f"panda_joint{number}": {f"joint{number}": 1.0} for number in range(1, 8)},
    "panda_gripper": {"left_finger": 1.0, "right_finger": 1.0},
    "panda_finger_joint1": {"left_finger": 1.0},
    "panda_finger_joint2": {"right_finger": -1.0},
}


def panda_options(router: str) -> dict[str, Any]:
    """The options of hal_ros2 for it."""
    parts = {
        "arm": {"trajectory": "/arm/joint_trajectory"},
        "gripper": {"positions": "/gripper/commands"},
    }
    return {"router": router, "joints": NAMES, "parts": parts}


class RosProcess:
    """The robot or the listener in a process of its own."""

    def __init__(self, folder: Path, module: str, **told: Any) -> None:
        words = [sys.executable, "-m", f"tests.ros2.{module}", json.dumps(told)]
        self.log = folder / f"{module}.log"
        with self.log.open("wb") as log:
            self._process = subprocess.Popen(
                words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, cwd=ROOT
            )
        self.got: list[dict[str, Any]] = []
        self._reader = threading.Thread(target=self._read)
        self._reader.start()
        self.wait(lambda: bool(self.got), "the program to start")

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.got.append(json.loads(line))

    def values(self, what: str) -> list[list[float]]:
        """What it was told so far on one topic."""
        return [one["values"] for one in list(self.got) if one["got"] == what]

    def tell(self, word: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(f"{word}\n".encode())
        self._process.stdin.flush()

    def wait(self, condition: Callable[[], bool], what: str, timeout_s: float = 30.0) -> None:
        def holds() -> bool:
            assert self._process.poll() is None, self.log.read_text()
            return condition()

        wait_for(holds, what, timeout_s)

    def end(self) -> None:
        self._process.kill()
        self._process.wait()
        self._reader.join()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()


StartRos = Callable[..., RosProcess]
