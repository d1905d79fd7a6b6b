"""A HAL process that breaks the contract in one way, named in its option ``fault``; "" in none.

Some faults are the backend's, some are a host's that decides for itself which row acts.
"""

from __future__ import annotations

import os
import sys
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import cycle
from typing import Any

import msgspec
import numpy as np

from fairlead.hal import core, plan_executor
from fairlead.hal.backend import BackendDescription, Measurement, PartCommand
from fairlead.hal.claims import ReleasedChunk
from fairlead.hal.core import HalCore
from fairlead.hal.host import HalHost
from fairlead.hal.lease_follower import LeaseFollower
from fairlead.hal.loop_state import PeriodClock
from fairlead.hal.process import Equipment, run_hal
from fairlead.hal.stop_register import StopRegister
from fairlead.messages import FloatArray, HalPart, Lease, SafeChunk, floats, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.service import ServiceContext, run_service
from fairlead_hal_kinematic.kinematic_backend import DELTA_GAIN, KinematicBackend
from fairlead_tools.measure.driven_robot import tool_chains

DRIFT = 2e-4
LATE_TICKS = 4
PAUSE_S = 0.3
OLD_TICKS = 4
SLOW = 1.5
UNEVEN = (-0.95, -0.95, 1.9)
"""By how many periods each of three ticks is late."""
DEGREES = 180.0 / np.pi
FOR_EVER_NS = 1 << 62


class BrokenBackend(KinematicBackend):
    """A robot without physics whose tool goes where it is told, but for its fault."""

    def __init__(self, robot: RobotManifest, profile: str, fault: str) -> None:
        self._fault = fault
        [self._chain] = tool_chains(robot).values()
        self._last: Mapping[str, PartCommand] = {}
        self._told: deque[Mapping[str, PartCommand]] = deque()
        self._past: deque[Measurement] = deque(maxlen=OLD_TICKS)
        self._read_s, self._old = time.monotonic(), 0
        super().__init__(robot, profile)

    def describe(self) -> BackendDescription:
        """What it says of itself, right or wrong."""
        found = super().describe()
        if self._fault != "ranges in degrees":
            return found
        return replace(found, parts=tuple(_parts_in_degrees(part) for part in found.parts))

    def read(self) -> Measurement:
        """What it measures, right or wrong."""
        found = super().read()
        if self._fault == "degrees":
            return replace(found, positions=found.positions * DEGREES)
        if self._fault == "velocities per tick":
            return replace(found, velocities=found.velocities * self._period_s)
        if self._fault == "not finite" and np.any(found.velocities != 0.0):
            return replace(found, efforts=found.efforts * np.nan)
        return self._maybe_old(found) if self._fault == "old states" else found

    def _maybe_old(self, found: Measurement) -> Measurement:
        now_s = time.monotonic()
        if now_s - self._read_s > PAUSE_S and len(self._past) == OLD_TICKS:
            self._old = OLD_TICKS
        self._read_s = now_s
        if self._old:
            self._old -= 1
            return self._past[-1 - self._old]
        self._past.append(found)
        return found

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        """What it is told, right or wrong."""
        before = self._positions.copy()
        if commands and self._fault == "dies":
            os._exit(1)
        if commands and self._fault == "raises":
            raise RuntimeError("as a driver may")
        if self._fault == "late":
            self._told.append(commands)
            commands = self._told.popleft() if len(self._told) > LATE_TICKS else {}
        held = not commands
        if self._fault == "goes on in a hold":
            commands = commands or self._last
        if self._fault == "gripper in degrees":
            commands = {name: _in_degrees(command) for name, command in commands.items()}
        self._last = commands
        super().apply(commands)
        moved = self._positions - before
        change = _MOVED.get(self._fault)
        if change is not None:
            moved = change(moved, held)
        self._positions = before + moved
        self._velocities = moved / self._period_s

    def _spread(self, target: FloatArray, own: list[int], motion: FloatArray) -> None:
        """By the description, and all joints slower where one would be too fast."""
        at = dict(zip(self._robot.measured_joint_names, super().read().positions, strict=True))
        names = [self._robot.joint_names[index] for index in own]
        wanted = motion / DELTA_GAIN
        if self._fault == "tool's frame":
            turn = self._chain.pose(at)[1]
            wanted = np.concatenate([turn @ wanted[:3], turn @ wanted[3:]])
        step = np.linalg.pinv(self._chain.jacobian(at, names), rcond=1e-2) @ wanted
        most = self._speed[own] * self._period_s
        if self._fault != "too fast":
            step = step / max(1.0, float(np.max(np.abs(step) / most)))
        target[own] += step


def _in_degrees(command: PartCommand) -> PartCommand:
    grips = command.mode is ControlMode.GRIPPER_POSITION
    return replace(command, values=command.values / DEGREES) if grips else command


def _parts_in_degrees(part: HalPart) -> HalPart:
    ranges = [
        msgspec.structs.replace(
            one,
            lower=pack_floats(DEGREES * floats(one.lower)),
            upper=pack_floats(DEGREES * floats(one.upper)),
        )
        for one in part.ranges
    ]
    return msgspec.structs.replace(part, ranges=tuple(ranges))


def _swapped(moved: FloatArray, held: bool) -> FloatArray:
    order = [1, 0, *range(2, len(moved))]
    return np.asarray(moved[order])


def _turned(moved: FloatArray, held: bool) -> FloatArray:
    return np.asarray(moved * np.where(np.arange(len(moved)) == 1, -1.0, 1.0))


def _drifting(moved: FloatArray, held: bool) -> FloatArray:
    return np.asarray(moved + DRIFT * held * (np.arange(len(moved)) == 2))


_MOVED: dict[str, Callable[[FloatArray, bool], FloatArray]] = {
    "swaps joints": _swapped,
    "turns a sign": _turned,
    "drifts": _drifting,
}


_is_fresh, _ASKED = LeaseFollower.is_fresh, [0, 0]


def _for_ever(self: LeaseFollower, now_ns: int) -> bool:
    return self.newest is not None


def _fresh_after_a_pause(self: LeaseFollower, now_ns: int) -> bool:
    """As if what was sent meanwhile were there already: whether it is depends on a thread."""
    if now_ns - _ASKED[0] > PAUSE_S * 1e9:
        _ASKED[1] = now_ns + int(PAUSE_S * 1e9)
    _ASKED[0] = now_ns
    return _is_fresh(self, now_ns) or now_ns < _ASKED[1]


def _last_row(self: ReleasedChunk, tick: int) -> int | None:
    row = tick - self.first_tick
    return row if row >= 0 else None


def _last_commands(self: ReleasedChunk, row: int) -> dict[int, PartCommand]:
    return _commands(self, min(row, self.horizon - 1))


def _left_epoch(self: LeaseFollower, epoch: int) -> bool:
    return False


_take_chunk, _grant, _offer, _start_tick = (
    HalCore.on_safe_chunk,
    LeaseFollower.grant,
    LeaseFollower.offer,
    PeriodClock.start_tick,
)
_run_tick, _commands, _LATE = HalHost._run_tick, ReleasedChunk.commands, cycle(UNEVEN)


def _any_lease(self: LeaseFollower, lease: Lease, now_ns: int) -> str:
    self._left_epochs.clear()
    return _offer(self, lease, now_ns)


def _any_epoch(self: LeaseFollower, claim_id: int, epoch: int, tick: int) -> Any:
    return _grant(self, claim_id, self.epoch, tick)


def _from_now_on(self: HalCore, message: SafeChunk) -> str:
    late = self._tick + 1 - message.first_tick
    if late > 0:
        message = msgspec.structs.replace(message, first_tick=message.first_tick + late)
    return _take_chunk(self, message)


def _slow(self: PeriodClock, now_ns: int) -> int:
    self._due_ns += int((SLOW - 1.0) * self._period_ns)
    return _start_tick(self, now_ns)


def _uneven(self: PeriodClock, now_ns: int) -> int:
    late = next(_LATE) * self._period_ns
    self._due_ns += int(late)
    return _start_tick(self, now_ns)


def _skipping(self: HalHost, stopping: Any) -> None:
    _run_tick(self, stopping)
    self._tick += 1 if self._tick % 40 == 0 else 0


_HOSTS: dict[str, list[tuple[Any, str, Any]]] = {
    "ignores that leases stop": [(LeaseFollower, "is_fresh", _for_ever)],
    "ignores that rows end": [
        (ReleasedChunk, "row_at", _last_row),
        (ReleasedChunk, "commands", _last_commands),
    ],
    "ignores a stop": [(StopRegister, "any_held", False)],
    "takes rows of an earlier epoch": [
        (LeaseFollower, "has_left", _left_epoch),
        (LeaseFollower, "grant", _any_epoch),
    ],
    "follows leases of an earlier epoch": [(LeaseFollower, "offer", _any_lease)],
    "takes rows of the past": [(HalCore, "on_safe_chunk", _from_now_on)],
    "ticks too slowly": [(PeriodClock, "start_tick", _slow)],
    "ticks unevenly": [(PeriodClock, "start_tick", _uneven)],
    "leaves ticks out": [(HalHost, "_run_tick", _skipping)],
    "goes on after SIGSTOP": [
        (core, "LEASE_LIFE_NS", FOR_EVER_NS),
        (plan_executor, "LEASE_LIFE_NS", FOR_EVER_NS),
        (LeaseFollower, "is_fresh", _fresh_after_a_pause),
    ],
}
"""What of the shipped host each of these replaces."""


async def body(context: ServiceContext) -> None:
    """As `fairlead_hal_kinematic`, around what is broken."""
    fault, profile = str(context.options.get("fault", "")), context.deployment.profile
    for where, name, value in _HOSTS.get(fault, []):
        setattr(where, name, value)
    await run_hal(
        context,
        lambda robot: Equipment(BrokenBackend(robot, profile, fault)),
        what=f"broken: {fault or 'intact'}",
    )


if __name__ == "__main__":
    sys.exit(run_service("bench.equipment.broken_hal", body))
