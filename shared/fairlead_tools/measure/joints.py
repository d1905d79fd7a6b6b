"""What the joints do under all drives: efforts, changes of what is measured, and coming to rest."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice

import numpy as np

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead_tools.measure.driven_robot import DrivenRobot, Moment, Tick
from fairlead_tools.measure.drives import STRETCH_TICKS, axes, together
from fairlead_tools.measure.rows import TARGETS

REST_TICKS = 20
MOST_STOP_TICKS = 60
SMALLER = 10.0 ** -np.arange(0.0, 6.5, 0.5)
"""Sizes of the steps that a dead band is looked for with, in step limits."""
DEAD_TICKS = 6
DEAD_SHARE = 0.1
"""A joint that made less than this of a step did not move."""


@dataclass
class JointRecord:
    """Over all ticks taken, per measured joint, shape ``[n]``.

    efforts: largest |effort| by ``free`` and ``touching``. moving: smallest change of the position
    in a tick in which a row told the joint to move at all; infinite where none did. jump: largest
    change in a tick. beyond: farthest outside its limits; both while free. speed: fastest; told:
    what it was told most, by joint modes alone, 0 where it was not.
    """

    driven: DrivenRobot
    efforts: dict[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        count = len(self.driven.robot.measured_joint_names)
        self.moving = np.full(count, np.inf)
        self.jump, self.beyond, self.speed, self.told = (np.zeros(count) for _ in range(4))
        self.free_ticks: list[bool] = []
        self._before: Tick | None = None

    def take(self, ticks: Iterable[Tick]) -> Iterator[Tick]:
        """Passes the ticks on."""
        for tick in ticks:
            self.free_ticks.append(tick.is_free)
            kind = "free" if tick.is_free else "touching"
            found = np.abs(tick.after.efforts)
            self.efforts[kind] = np.maximum(self.efforts.get(kind, 0.0 * found), found)
            change = np.abs(tick.after.positions - tick.before.positions)
            if tick.is_free:
                self.jump = np.maximum(self.jump, change)
                self.beyond = np.maximum(self.beyond, self._outside(tick.after))
            for command in tick.commands.values():
                self._note_told(tick, command, change)
            self._before = tick
            yield tick

    def _outside(self, now: Moment) -> FloatArray:
        robot = self.driven.robot
        ends = [
            (one.lower, one.upper) if one.has_bounds else (-np.inf, np.inf)
            for one in (*robot.joints, *robot.passive_joints)
        ]
        lower, upper = np.array(ends).T
        outside = np.maximum(lower - now.positions, now.positions - upper)
        return np.asarray(np.maximum(outside, 0.0))

    def _note_told(self, tick: Tick, command: PartCommand, change: FloatArray) -> None:
        told = _told_rates(tick, self._before, command, self.driven.period_s)
        for joint, rate in told.items():
            if rate > 0.0 and tick.is_free:
                self.moving[joint] = min(self.moving[joint], change[joint])
                self.told[joint] = max(self.told[joint], rate)
                speed = abs(float(tick.after.velocities[joint]))
                self.speed[joint] = max(self.speed[joint], speed)


def _told_rates(
    tick: Tick, before: Tick | None, command: PartCommand, period_s: float
) -> dict[int, float]:
    """How fast a row tells each joint to go; {} for a mode that does not say, or a first row."""
    if command.mode is ControlMode.JOINT_VELOCITY:
        return {joint: abs(float(command.values[joint])) for joint in command.active}
    if command.mode not in TARGETS or before is None or before.after is not tick.before:
        return {}
    for last in before.commands.values():
        if (last.mode, last.active) == (command.mode, command.active):
            rates = np.abs(command.values - last.values) / period_s
            return {joint: float(rates[joint]) for joint in command.active}
    return {}


def resting(driven: DrivenRobot) -> tuple[FloatArray, FloatArray]:
    """Largest change in a tick and largest speed of each measured joint, nothing commanded."""
    before = driven.look()
    for _ in range(REST_TICKS):
        before = driven.step("rest", before, {}).after
    change = speed = np.zeros(len(driven.robot.measured_joint_names))
    for _ in range(REST_TICKS):
        after = driven.step("rest", before, {}).after
        change = np.maximum(change, np.abs(after.positions - before.positions))
        speed = np.maximum(speed, np.abs(after.velocities))
        before = after
    return change, speed


def dead_bands(driven: DrivenRobot) -> dict[str, float]:
    """Per joint with targets or velocities, the largest step that did not move it [rad or m]."""
    found: dict[str, float] = {}
    for part, modes in driven.modes.items():
        mode = next((m for m in (*TARGETS, ControlMode.JOINT_VELOCITY) if m in modes), None)
        if mode is None:
            continue
        limits = getattr(driven.robot.profile(driven.profile).parts[part], mode.yaml_name)
        for joint, most in zip(driven.indices(part), limits.step_limits, strict=True):
            per_tick = most if mode in TARGETS else most * driven.period_s
            found[driven.robot.joint_names[joint]] = _dead_band(driven, part, mode, joint, per_tick)
    return found


def _dead_band(driven: DrivenRobot, part: str, mode: ControlMode, joint: int, most: float) -> float:
    own = tuple(driven.indices(part))
    for size in most * SMALLER:
        now = driven.reset(0)
        start, values = now.positions[joint], np.zeros(driven.robot.n_dof)
        if mode in TARGETS:
            values[list(own)] = now.positions[list(own)]
        away = size * (1.0 if _has_room(driven, joint, float(start)) else -1.0)
        values[joint] += away if mode in TARGETS else away / driven.period_s
        for _ in range(DEAD_TICKS):
            row = PartCommand(mode, "", values, own)
            now = driven.step("dead band", now, {part: row}).after
        told = size if mode in TARGETS else size * DEAD_TICKS
        if abs(now.positions[joint] - start) < DEAD_SHARE * told:
            return float(size)
    return 0.0


def _has_room(driven: DrivenRobot, index: int, position: float) -> bool:
    joint = driven.robot.joints[index]
    return not joint.has_bounds or position < 0.5 * (joint.lower + joint.upper)


def stop_ticks(driven: DrivenRobot, drive_ticks: int, shift: int) -> tuple[bool, FloatArray]:
    """Per measured joint, the held ticks until it stands still for good, after driving.

    First whether the robot was free to move, from the start of the drive to the end.
    """
    now = driven.reset(shift)
    for tick in together(driven, drive_ticks, shift, seed=shift):
        now = tick.after
    return _held_until_still(driven, now)


def gentle_stop(
    driven: DrivenRobot, part: str, mode: ControlMode, share: float
) -> tuple[bool, FloatArray]:
    """As `stop_ticks`, after one axis of one part at a share of full scale."""
    now = driven.reset(0)
    for tick in islice(axes(driven, part, mode, share), STRETCH_TICKS):
        now = tick.after
    return _held_until_still(driven, now)


def watched_ticks(driven: DrivenRobot) -> int:
    """So many held ticks are looked at: twice as long as a stop may take by robot.yaml."""
    ramp_s = driven.robot.profile(driven.profile).protocol.stop_ramp_ms * 1e-3
    return max(MOST_STOP_TICKS, math.ceil(2.0 * ramp_s / driven.period_s))


def _held_until_still(driven: DrivenRobot, now: Moment) -> tuple[bool, FloatArray]:
    measured = driven.robot.profile(driven.profile).measured
    names = driven.robot.measured_joint_names
    still = np.array([measured[name].standstill_per_s for name in names])
    found = np.zeros(len(names))
    for count in range(watched_ticks(driven)):
        found[np.abs(now.velocities) >= still] = count + 1
        now = driven.step("stop", now, {}).after
    return driven.is_free, found
