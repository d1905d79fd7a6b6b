"""What the joints do under all drives: efforts, changes of what is measured, and coming to rest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from bench.measure_limits.driven_robot import DrivenRobot, Tick
from bench.measure_limits.drives import together
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode

REST_TICKS = 20
MOST_STOP_TICKS = 60


@dataclass
class JointRecord:
    """Over all ticks taken, per measured joint, shape ``[n]``.

    efforts: largest |effort| by ``free``, ``touching`` and ``oracle``. moving: smallest change of
    the position in a tick in which a joint velocity row told the joint to move faster than the
    dead band; infinite where none did.
    """

    dead_band_per_tick: FloatArray
    efforts: dict[str, FloatArray] = field(default_factory=dict)
    moving: FloatArray = field(default_factory=lambda: np.zeros(0))

    def take(self, ticks: Iterable[Tick], period_s: float) -> Iterator[Tick]:
        """Passes the ticks on."""
        for tick in ticks:
            kind = "oracle" if tick.kind == "oracle" else "free" if tick.is_free else "touching"
            found = np.abs(tick.after.efforts)
            self.efforts[kind] = np.maximum(self.efforts.get(kind, 0.0 * found), found)
            self._note_change(tick, period_s)
            yield tick

    def _note_change(self, tick: Tick, period_s: float) -> None:
        change = np.abs(tick.after.positions - tick.before.positions)
        if not self.moving.size:
            self.moving = np.full(change.shape, np.inf)
        for command in tick.commands.values():
            if command.mode is ControlMode.JOINT_VELOCITY:
                for joint in command.active:
                    told = abs(command.values[joint]) * period_s
                    if told > self.dead_band_per_tick[joint]:
                        self.moving[joint] = min(self.moving[joint], change[joint])


def resting_change(driven: DrivenRobot) -> FloatArray:
    """Largest change of each measured position in a tick at rest, nothing commanded."""
    for _ in range(REST_TICKS):
        driven.backend.apply({})
    worst = np.zeros(len(driven.robot.measured_joint_names))
    before = driven.look()
    for _ in range(REST_TICKS):
        driven.backend.apply({})
        after = driven.look()
        worst = np.maximum(worst, np.abs(after.positions - before.positions))
        before = after
    return worst


def stop_ticks(driven: DrivenRobot, drive_ticks: int, shift: int) -> tuple[bool, FloatArray]:
    """Per measured joint, the held ticks until it stands still for good, after driving.

    First whether the robot was free to move, from the start of the drive to the end.
    """
    measured = driven.robot.profile("sim").measured
    names = driven.robot.measured_joint_names
    still = np.array([measured[name].standstill_per_s for name in names])
    now = driven.reset(shift)
    for tick in together(driven, drive_ticks, shift, seed=shift):
        now = tick.after
    found = np.zeros(len(names))
    for count in range(MOST_STOP_TICKS):
        found[np.abs(now.velocities) >= still] = count + 1
        now = driven.step("stop", now, {}).after
    return driven.is_free, found
