"""Every joint state of one HAL as it came, and where its base was."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fairlead.errors import MessageError
from fairlead.frames import ODOM
from fairlead.keys import Keys
from fairlead.messages import (
    Acted,
    FloatArray,
    HalStatus,
    JointState,
    TransformBatch,
    decode,
    floats,
)
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.bus import Bus, Sample
from fairlead_tools.conformance.row import SilentHalError

SILENCE_S = 10.0
SILENT_PERIODS = 40
MOST_NOTES = 20


@dataclass(frozen=True)
class Heard:
    """One state; the arrays are of commanded, then passive joints.

    came_ns: CLOCK_MONOTONIC here. stamp_ns: the HAL's, when it measured.
    """

    tick: int
    came_ns: int
    stamp_ns: int
    positions: FloatArray
    velocities: FloatArray
    efforts: FloatArray
    acted: tuple[Acted, ...]


class HeardStates:
    """States by tick. What cannot be one of this robot's is noted in ``unfit`` and left out.

    Args:
        on_state: called after each new one, on the transport's thread.
    """

    def __init__(
        self,
        bus: Bus,
        keys: Keys,
        robot: RobotManifest,
        hal: HalStatus,
        on_state: Callable[[], None],
    ) -> None:
        self._robot, self._hal, self._on_state = robot, hal, on_state
        self._count = len(robot.measured_joint_names)
        self._changed = threading.Condition()
        self.by_tick: dict[int, Heard] = {}
        self.bases: dict[int, FloatArray] = {}
        self.order: list[int] = []
        self.unfit: list[str] = []
        self._silence_s = max(SILENCE_S, SILENT_PERIODS * hal.period_ns * 1e-9)
        self._subscriptions = [bus.subscribe(keys.joints, self._on_joints)]
        if robot.base_joints:
            self._subscriptions.append(bus.subscribe(keys.every_tf, self._on_frames))

    @property
    def newest_tick(self) -> int:
        """0 before the first."""
        return self.order[-1] if self.order else 0

    @property
    def newest(self) -> Heard:
        """The newest state; there must be one."""
        with self._changed:
            return self.by_tick[self.newest_tick]

    def every(self) -> list[Heard]:
        """All that came so far, in the order in which they came."""
        with self._changed:
            return [self.by_tick[tick] for tick in self.order]

    def last_until(self, tick: int) -> Heard:
        """The state of a tick, or the newest before it that came; there must be one."""
        with self._changed:
            return self.by_tick[max(one for one in self.by_tick if one <= tick)]

    def between(self, first: int, stop: int) -> list[Heard]:
        """States of a half-open range of ticks, as far as they came."""
        return [self.by_tick[tick] for tick in range(first, stop) if tick in self.by_tick]

    def acted(self, tick: int) -> tuple[Acted, ...] | None:
        """What the parts did in a tick, told in the next; None: it did not come."""
        told = self.by_tick.get(tick + 1)
        return None if told is None else told.acted

    def wait_tick(self, tick: int) -> None:
        """Raises `SilentHalError` where nothing new comes for 10 s or 40 periods."""
        with self._changed:
            while self.newest_tick < tick:
                before = self.newest_tick
                self._changed.wait(self._silence_s)
                if self.newest_tick == before:
                    why = f"no joint state after tick {before} within {self._silence_s:g} s"
                    if self.unfit:
                        why += f"; {self.unfit[-1]}"
                    raise SilentHalError(why)

    def wait_for(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Whether a condition of what was heard came true in time."""
        with self._changed:
            return self._changed.wait_for(condition, timeout_s)

    def close(self) -> None:
        """Hear no more."""
        for one in self._subscriptions:
            one.undeclare()

    def _on_joints(self, sample: Sample) -> None:
        now_ns = time.monotonic_ns()
        try:
            state = decode(JointState, sample.payload)
        except MessageError as error:
            self._note(str(error))
            return
        problem = self._problem(state)
        with self._changed:
            if state.tick in self.by_tick:
                fresh = False  # a paused world in lockstep repeats its tick
            elif problem:
                self._note(f"tick {state.tick}: {problem}")
                fresh = False
            else:
                fresh = True
                self.order.append(state.tick)
                self.by_tick[state.tick] = _heard(state, now_ns)
                self._changed.notify_all()
        if fresh or not problem:
            self._on_state()

    def _problem(self, state: JointState) -> str:
        if state.session != self._hal.session:
            return f"session {state.session:x}, its status says {self._hal.session:x}"
        if state.robot_hash != self._hal.robot_hash:
            return "another robot_hash than in its status"
        if len(state.acted) != len(self._robot.parts):
            return f"acted of {len(state.acted)} parts, there are {len(self._robot.parts)}"
        for what in ("positions", "velocities", "efforts"):
            values = getattr(state, what)
            if len(values) != 8 * self._count:
                return f"{len(values) / 8:g} {what}, there are {self._count} joints"
            odd = np.flatnonzero(~np.isfinite(floats(values)))
            if odd.size:
                return f"{what}: {self._robot.measured_joint_names[odd[0]]} is not finite"
        if self.order and state.tick < self.order[-1] and state.tick not in self.by_tick:
            return f"came after tick {self.order[-1]}"
        return ""

    def _note(self, problem: str) -> None:
        if len(self.unfit) < MOST_NOTES:
            self.unfit.append(problem)

    def _on_frames(self, sample: Sample) -> None:
        try:
            batch = decode(TransformBatch, sample.payload)
        except MessageError as error:
            self._note(str(error))
            return
        for one in batch.transforms:
            if (one.parent, one.child) != (ODOM, self._robot.base_frame) or batch.is_static:
                continue
            if (len(one.translation), len(one.rotation_xyzw)) == (24, 32):
                z, w = floats(one.rotation_xyzw)[2:]
                yaw = 2.0 * np.arctan2(z, w)
                self.bases[batch.tick] = np.array([*floats(one.translation)[:2], yaw])


def _heard(state: JointState, came_ns: int) -> Heard:
    positions, velocities, efforts = (
        floats(one) for one in (state.positions, state.velocities, state.efforts)
    )
    return Heard(state.tick, came_ns, state.stamp_ns, positions, velocities, efforts, state.acted)
