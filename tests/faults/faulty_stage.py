"""The light robot with a HAL that breaks when it is told to."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.faults.faulty_hal import FAULT_FILE
from tests.faults.live_stage import Changes, LiveStage, live_stage


class FaultyStage(LiveStage):
    """fault_file: holds the name of the fault the robot has now."""

    fault_file: Path

    def fault(self, name: str) -> int:
        """Give the robot a fault, or none with "".

        Returns:
            CLOCK_MONOTONIC just before [ns].
        """
        now_ns = time.monotonic_ns()
        new = self.fault_file.with_suffix(".new")
        new.write_text(name, encoding="ascii")
        new.replace(self.fault_file)
        return now_ns


@contextmanager
def faulty_stage(folder: Path) -> Iterator[FaultyStage]:
    """All services, and no fault yet."""
    file = folder / "fault"
    file.write_text("", encoding="ascii")
    path = os.pathsep.join(filter(None, [str(Path.cwd()), os.environ.get("PYTHONPATH")]))
    changes = Changes(
        environment={"hal": {FAULT_FILE: str(file), "PYTHONPATH": path}}, command=_faulty
    )
    with live_stage(folder, changes) as robot:
        stage = FaultyStage(robot.robot)
        stage.fault_file = file
        yield stage


def _faulty(service: str, words: list[str]) -> list[str]:
    if service != "hal":
        return words
    return ["tests.faults.faulty_hal" if word == "fairlead_hal_sim" else word for word in words]
