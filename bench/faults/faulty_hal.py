"""A HAL process whose light robot can break: a real host around a backend that reads its fault.

The test writes the fault's name into the file that `FAULT_FILE` names; empty: none.
"""

from __future__ import annotations

import os
import queue
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fairlead.hal import identity
from fairlead.hal.backend import BackendDescription, FramePose, Measurement, PartCommand
from fairlead.hal.process import Equipment, run_hal
from fairlead.messages import HalCamera, Image
from fairlead.robot.manifest import RobotManifest
from fairlead.service import ServiceContext, run_service
from fairlead_hal_kinematic.kinematic_backend import KinematicBackend
from fairlead_hal_kinematic.options import KinematicOptions

FAULT_FILE = "FAIRLEAD_TEST_FAULT"
JOINT = "panda_joint1"
OFFSET_RAD = 0.3
PUSH_M = 0.05
CONTACT = 1e3
GRIPPER, OBJECT_M = "panda_gripper", 0.015
CAMERA = HalCamera(name="front", width=32, height=24, period_ticks=2)


class FaultyBackend(KinematicBackend):
    """Moves like any other light robot, but measures and moves as its fault says."""

    _file = Path(os.environ.get(FAULT_FILE, os.devnull))
    _frozen: Measurement | None = None
    _newest: Mapping[str, PartCommand] = {}

    @property
    def fault(self) -> str:
        """The fault it has now."""
        return self._file.read_text(encoding="ascii").strip()

    def describe(self) -> BackendDescription:
        """With a camera that can break, too."""
        return replace(super().describe(), cameras=(CAMERA,))

    def read(self) -> Measurement:
        """What a broken sensor says."""
        true, fault = super().read(), self.fault
        if fault != "frozen":
            self._frozen = true
        if fault == "frozen" and self._frozen is not None:
            return self._frozen
        if fault == "object":
            return self._with_object(true)
        change = _MEASURED.get(fault)
        return change(true, self._joints[JOINT]) if change else true

    def _with_object(self, true: Measurement) -> Measurement:
        """The fingers stop at what they hold."""
        gripper, n = self._joints[GRIPPER], len(self._positions)
        positions, velocities = true.positions.copy(), true.velocities.copy()
        if positions[gripper] > OBJECT_M:
            return true
        positions[gripper], velocities[gripper] = OBJECT_M, 0.0
        positions[n:] += self._shares @ (positions - true.positions)[:n]
        velocities[n:] += self._shares @ (velocities - true.velocities)[:n]
        return replace(true, positions=positions, velocities=velocities)

    def transforms(self) -> Sequence[FramePose]:
        """What a broken localiser says of the object."""
        frames = list(super().transforms())
        change = _FRAMES.get(self.fault)
        return frames if change is None else change(frames)

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        """A robot that does not stop goes on as it was told last."""
        if self.fault == "runs on":
            commands = {**self._newest, **commands}
        elif commands:
            self._newest = dict(commands)
        super().apply(commands)
        if self.fault == "pushed":
            self._positions[self._joints["base_x"]] += PUSH_M
            self._velocities[self._joints["base_x"]] += PUSH_M / self._period_s


class FaultyFeed:
    """A camera before a still scene: every picture looks the same, and its exposure is new.

    Implements `fairlead.hal.backend.CameraFeed`.
    """

    failure = ""

    def __init__(self, backend: FaultyBackend) -> None:
        self._backend, self._tick = backend, 0
        self._made: queue.SimpleQueue[Image] = queue.SimpleQueue()
        ramp = np.arange(CAMERA.width * CAMERA.height * 3) % 251
        self._scene = ramp.astype(np.uint8).tobytes()

    def request(self, session: int, tick: int, cameras: Sequence[str], snapshot: bytes) -> bool:
        """Expose, unless the camera stalls; one that repeats sends its last exposure again."""
        fault = self._backend.fault
        if fault == "camera stalls":
            return True
        if fault != "camera repeats":
            self._tick = tick
        data = bytes(len(self._scene)) if fault == "camera goes black" else self._scene
        self._made.put(
            Image(session=session, tick=self._tick, camera=CAMERA.name, width=CAMERA.width,
                  height=CAMERA.height, encoding_name="rgb8", data=data)
        )  # fmt: skip
        return True

    def take(self, timeout_s: float) -> Image | None:
        """The next picture."""
        try:
            return self._made.get(timeout=timeout_s)
        except queue.Empty:
            return None

    def close(self) -> None:
        """Nothing to end."""


def _nan(true: Measurement, joint: int) -> Measurement:
    positions = true.positions.copy()
    positions[joint] = np.nan
    return replace(true, positions=positions)


def _offset(true: Measurement, joint: int) -> Measurement:
    positions = true.positions.copy()
    positions[joint] += OFFSET_RAD
    return replace(true, positions=positions)


def _contact(true: Measurement, joint: int) -> Measurement:
    efforts = true.efforts.copy()
    efforts[joint] = CONTACT
    return replace(true, efforts=efforts)


def _without(frames: list[FramePose]) -> list[FramePose]:
    return [frame for frame in frames if frame.child != "object"]


def _renamed(frames: list[FramePose]) -> list[FramePose]:
    return [replace(f, child="objekt") if f.child == "object" else f for f in frames]


def _loop(frames: list[FramePose]) -> list[FramePose]:
    parents = {"object": "goal", "goal": "object"}
    return [replace(f, parent=parents.get(f.child, f.parent)) for f in frames]


_MEASURED: dict[str, Callable[[Measurement, int], Measurement]] = {
    "nan": _nan,
    "offset": _offset,
    "contact": _contact,
}
_FRAMES: dict[str, Callable[[list[FramePose]], list[FramePose]]] = {
    "frame stale": _without,
    "frame renamed": _renamed,
    "frames in a loop": _loop,
}


async def body(context: ServiceContext) -> None:
    """As `fairlead_hal_kinematic`, around the backend that can break."""
    options, profile = KinematicOptions(**context.options), context.deployment.profile

    def equip(robot: RobotManifest) -> Equipment:
        backend = FaultyBackend(robot, profile, options.frames)
        return Equipment(backend, FaultyFeed(backend))

    identity.gate_limits = lambda *_: b""  # the gate's file is a stricter one
    await run_hal(context, equip, what="faulty")


if __name__ == "__main__":
    sys.exit(run_service("bench.faults.faulty_hal", body))
