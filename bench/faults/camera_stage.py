"""The real simulator, which renders cameras while faults are done to its robot."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path

from bench.equipment.live_robot import wait_for
from bench.equipment.motion_log import longest_tick_ms
from bench.equipment.rendering import CAN_RENDER
from bench.faults.live_stage import LATE_TICK_MS, LiveStage, live_stage
from bench.faults.row import MachineLateError, NotHereError
from fairlead.operate.goal_hearing import Progress
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.scratch import ScratchRobot

CAMERAS = ("robot0_agentview_left", "robot0_agentview_right", "robot0_eye_in_hand")
SIZE_PX, PERIOD_TICKS = 256, 4
SIMULATOR = {
    "cameras": [
        {"name": name, "width": SIZE_PX, "height": SIZE_PX, "period_ticks": PERIOD_TICKS}
        for name in CAMERAS
    ],
}


class CameraStage(LiveStage):
    """frame_stamps: CLOCK_MONOTONIC of each picture that came [ns]."""

    def __init__(self, robot: ScratchRobot) -> None:
        self.frame_stamps: list[int] = []
        super().__init__(robot)
        for name in CAMERAS:
            self.client.bus.subscribe(self.client.keys.camera(name), self._on_frame)

    def _on_frame(self, sample: Sample) -> None:
        self.frame_stamps.append(time.monotonic_ns())

    def start_moving(self, seed: int = 0) -> Future[Progress]:
        """As every robot; where the simulator has no time for its ticks, the machine is late."""
        began_ns = time.monotonic_ns()
        try:
            return super().start_moving(seed)
        except AssertionError as error:
            self.in_time(began_ns, time.monotonic_ns(), str(error))
            raise

    def in_time(self, began_ns: int, ended_ns: int, what: str) -> None:
        """Asserts that the simulator kept its ticks in a stretch of time.

        Raises:
            MachineLateError: it did not, so ``what`` happened.
        """
        lines = [line for line in self.motion.since(began_ns) if line.stamp_ns <= ended_ns]
        tick_ms = longest_tick_ms(lines)
        if tick_ms > LATE_TICK_MS:
            raise MachineLateError(f"ticks of up to {tick_ms:.0f} ms: {what[:200]}")

    def frames_a_second(self, began_ns: int, ended_ns: int) -> float:
        """Pictures of all cameras together, in a stretch of time."""
        count = sum(began_ns <= stamp <= ended_ns for stamp in list(self.frame_stamps))
        return count / ((ended_ns - began_ns) / 1e9)


@contextmanager
def camera_stage(folder: Path) -> Iterator[CameraStage]:
    """All services around the simulator, cameras on."""
    if not CAN_RENDER:
        raise NotHereError("no rendering library on this machine")
    with live_stage(folder, simulator=SIMULATOR) as robot:
        stage = CameraStage(robot.robot)
        wait_for(lambda: bool(stage.frame_stamps), "the first picture", 120.0)
        yield stage
