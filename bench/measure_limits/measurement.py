"""All drives of one robot, and everything noted on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from bench.measure_limits.driven_robot import DrivenRobot, Tick
from bench.measure_limits.drives import alone, axes, modes_of, together
from bench.measure_limits.episodes import episode
from bench.measure_limits.joints import JointRecord, resting_change, stop_ticks
from bench.measure_limits.reach import Reach
from bench.measure_limits.tracking import TrackingModel
from fairlead.messages import FloatArray

DEAD_BAND_PER_TICK = {"base_x": 0.0125, "base_y": 0.0125, "base_yaw": 0.00834}
"""Dry friction of the simulated base over its servos' gain, per period [m, m, rad]."""


@dataclass(frozen=True)
class Amount:
    """How much to drive. random: ticks of each random drive. stops: drives that end in a stop."""

    random: int
    episodes: int
    stops: int


@dataclass
class Measurement:
    """ticks: by kind of drive. stops: whether free, and ticks to standstill per measured joint."""

    driven: DrivenRobot
    tracking: TrackingModel
    joints: JointRecord
    reach: Reach = field(default_factory=Reach)
    ticks: dict[str, int] = field(default_factory=dict)
    resting: FloatArray = field(default_factory=lambda: np.zeros(0))
    stops: list[tuple[bool, FloatArray]] = field(default_factory=list)

    def stops_by_joint(self, free: bool) -> dict[str, float]:
        """Ticks from the first held one until a joint stands still, in the worst drive."""
        names = self.driven.robot.measured_joint_names
        seen = [ticks for was_free, ticks in self.stops if was_free == free]
        worst = np.max(seen, axis=0) if seen else np.zeros(len(names))
        return {name: float(ticks) for name, ticks in zip(names, worst, strict=True)}


def measure(robot: str, amount: Amount, on_progress: Callable[[str], None]) -> Measurement:
    """Everything; ``on_progress`` is told what comes next."""
    driven = DrivenRobot(robot)
    names = driven.robot.measured_joint_names
    dead_band = np.array([DEAD_BAND_PER_TICK.get(name, 0.0) for name in names])
    found = Measurement(driven, TrackingModel(driven), JointRecord(dead_band))
    driven.reset(0)
    found.resting = resting_change(driven)
    for what, ticks in _drives(driven, amount):
        on_progress(what)
        found.tracking.take(_noted(found, ticks))
    for count in range(amount.stops):
        on_progress(f"stop {count + 1} of {amount.stops}")
        found.stops.append(stop_ticks(driven, 16 + 5 * (count % 9), count))
    return found


def _drives(driven: DrivenRobot, amount: Amount) -> Iterator[tuple[str, Iterable[Tick]]]:
    for seed in range(amount.episodes):
        yield f"demonstration {seed + 1} of {amount.episodes}", episode(driven, seed)
    for part, mode in modes_of(driven) if amount.random else []:
        yield f"{part}: {mode.yaml_name}, axis by axis", axes(driven, part, mode)
        yield f"{part}: {mode.yaml_name}, at random", alone(driven, part, mode, amount.random)
    for shift in range(max(len(part.modes) for part in driven.robot.parts)):
        yield f"all parts at random ({shift + 1})", together(driven, amount.random, shift)


def _noted(found: Measurement, ticks: Iterable[Tick]) -> Iterator[Tick]:
    taken = found.joints.take(found.reach.take(found.driven, ticks), found.driven.period_s)
    for tick in taken:
        found.ticks[tick.kind] = found.ticks.get(tick.kind, 0) + 1
        yield tick
