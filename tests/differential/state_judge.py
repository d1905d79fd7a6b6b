"""G011, G013 and another HAL's states, from the rules, not the gate's code."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from bench.equipment.case import Measured, Pacing
from tests.differential.gate_file import GateFile

REMEMBERED = 8
ANOTHER_HAL = (2, "two HALs")


@dataclass
class StateJudge:
    """An armed gate's memory of states; its life ends with the first stop.

    last: the newest state since arming: "arming clears the memory" of where joints were.
    newest: the newest state of all, and what had acted in it.
    timeout_ns: how long there may be no new state in realtime; a repeated one is not new.
    arrivals: tick and time [ns] of the last states, those before arming too.
    """

    file: GateFile
    pacing: Pacing
    period_ns: int
    timeout_ns: int
    newest: tuple[Measured, object]
    last: Measured | None = None
    arrivals: deque[tuple[int, int]] = field(default_factory=lambda: deque(maxlen=REMEMBERED))
    is_moving: bool = False

    def on_state(self, state: Measured, acted: object, now_ns: int) -> tuple[int, str]:
        """(code, joint or field) of the stop it raises, (0, "") if none.

        is_moving has been set if a row of a live claim has been executed, this state's included.
        """
        silence_ns = now_ns - max((arrived for _, arrived in self.arrivals), default=now_ns)
        if self.pacing == "realtime" and silence_ns > self.timeout_ns:
            return 11, "state age"
        newest = self.newest[0].tick
        if state.tick < newest:
            return 0, ""
        fault = self._unmeasured(state)
        if fault is not None:
            return fault
        if state.tick == newest:
            return (0, "") if self._repeats(state, acted) else ANOTHER_HAL
        if self._claims_too_many_ticks(state.tick, newest, now_ns):
            return 13, "tick"
        fault = self._leapt(state)
        self.arrivals.append((state.tick, now_ns))
        self.last, self.newest = state, (state, acted)
        return fault or (0, "")

    def _repeats(self, state: Measured, acted: object) -> bool:
        """ "a tick told twice otherwise"."""
        before, acted_before = self.newest
        return acted == acted_before and all(
            np.array_equal(getattr(state, name), getattr(before, name))
            for name in ("positions", "velocities", "efforts")
        )

    def _unmeasured(self, state: Measured) -> tuple[int, str] | None:
        """ "G011 measured state: every joint, finite"."""
        joints = (*self.file.joints, *self.file.passive)
        blocks = (
            ("positions", state.positions),
            ("velocities", state.velocities),
            ("efforts", state.efforts),
        )
        for name, values in blocks:
            if len(values) != len(joints):
                return 11, name
        for index, joint in enumerate(joints):
            if not all(math.isfinite(values[index]) for _, values in blocks):
                return 11, joint.name
        return None

    def _claims_too_many_ticks(self, tick: int, newest: int, now_ns: int) -> bool:
        """ "in realtime a state may be ahead of one of the last eight by the periods that have
        passed since that one arrived, rounded up, plus one ... In lockstep, once the HAL has
        executed a row of a live claim, by one tick"."""
        if self.pacing == "lockstep":
            return self.is_moving and tick > newest + 1
        return bool(self.arrivals) and not any(
            tick - earlier <= math.ceil((now_ns - arrived_ns) / self.period_ns) + 1
            for earlier, arrived_ns in self.arrivals
        )

    def _leapt(self, state: Measured) -> tuple[int, str] | None:
        """ "G013 measured position moves no further than the robot can in the ticks between"."""
        if self.last is None:
            return None
        ticks = state.tick - self.last.tick
        for index, joint in enumerate((*self.file.joints, *self.file.passive)):
            moved = abs(float(state.positions[index]) - float(self.last.positions[index]))
            if not moved <= joint.jump_limit * ticks:
                return 13, joint.name
        return None
