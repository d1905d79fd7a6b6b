"""All drives of one robot, and everything noted on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from fairlead.messages import FloatArray
from fairlead_tools.measure.driven_robot import DrivenRobot, Tick
from fairlead_tools.measure.drives import alone, axes, modes_of, together
from fairlead_tools.measure.joints import (
    JointRecord,
    dead_bands,
    gentle_stop,
    resting,
    stop_ticks,
    watched_ticks,
)
from fairlead_tools.measure.tracking import TrackingModel


@dataclass(frozen=True)
class Amount:
    """How much to drive. random: ticks of each random drive. stops: drives that end in a stop."""

    random: int
    stops: int


@dataclass
class Measurement:
    """ticks: by kind of drive. stops: whether free, and ticks to standstill per measured joint.

    contacts: what touches while the robot rests. rest_change, rest_speed: per measured joint.
    share: of full scale that was asked for.
    """

    driven: DrivenRobot
    tracking: TrackingModel
    joints: JointRecord
    contacts: list[str] = field(default_factory=list)
    dead_bands: dict[str, float] = field(default_factory=dict)
    ticks: dict[str, int] = field(default_factory=dict)
    rest_change: FloatArray = field(default_factory=lambda: np.zeros(0))
    rest_speed: FloatArray = field(default_factory=lambda: np.zeros(0))
    stops: list[tuple[bool, FloatArray]] = field(default_factory=list)
    share: float = 1.0

    @property
    def unfinished(self) -> list[str]:
        """Joints that still moved when watching a stop ended."""
        most = watched_ticks(self.driven)
        last = np.max([ticks for _, ticks in self.stops], axis=0, initial=0)
        names = self.driven.robot.measured_joint_names
        return [
            name for name, ticks in zip(names, np.atleast_1d(last), strict=False) if ticks >= most
        ]

    def stop_s(self) -> FloatArray:
        """Longest time from the first held tick until each measured joint stood still [s].

        After a contact it counts only where every drive had one.
        """
        seen = [ticks for free, ticks in self.stops if free] or [ticks for _, ticks in self.stops]
        names = self.driven.robot.measured_joint_names
        worst = np.max(seen, axis=0) if seen else np.zeros(len(names))
        return np.asarray(worst * self.driven.period_s)


def measure(driven: DrivenRobot, amount: Amount, on_progress: Callable[[str], None]) -> Measurement:
    """Everything; ``on_progress`` is told what comes next."""
    found = Measurement(driven, TrackingModel(driven), JointRecord(driven))
    on_progress("at rest")
    driven.reset(0)
    found.contacts = driven.contacts()
    found.rest_change, found.rest_speed = resting(driven)
    on_progress("dead bands")
    found.dead_bands = dead_bands(driven)
    for what, ticks in _drives(driven, amount):
        on_progress(what)
        found.tracking.take(_noted(found, ticks))
    for count in range(amount.stops):
        on_progress(f"stop {count + 1} of {amount.stops}")
        found.stops.append(stop_ticks(driven, 16 + 5 * (count % 9), count))
    return found


def measure_gently(
    driven: DrivenRobot, share: float, on_progress: Callable[[str], None]
) -> Measurement:
    """What can be asked of a robot: each axis alone at a share of full scale, and a stop."""
    found = Measurement(driven, TrackingModel(driven), JointRecord(driven), share=share)
    on_progress("at rest")
    driven.reset(0)
    found.rest_change, found.rest_speed = resting(driven)
    for part, mode in modes_of(driven):
        on_progress(f"{part}: {mode.yaml_name}, axis by axis, at {share:g} of full scale")
        found.tracking.take(_noted(found, axes(driven, part, mode, share)))
        on_progress(f"{part}: {mode.yaml_name}, to a stop")
        found.stops.append(gentle_stop(driven, part, mode, share))
    return found


def _drives(driven: DrivenRobot, amount: Amount) -> Iterator[tuple[str, Iterable[Tick]]]:
    for part, mode in modes_of(driven):
        yield f"{part}: {mode.yaml_name}, axis by axis", axes(driven, part, mode)
        yield f"{part}: {mode.yaml_name}, at random", alone(driven, part, mode, amount.random)
    for shift in range(max(map(len, driven.modes.values()))):
        yield f"all parts at random ({shift + 1})", together(driven, amount.random, shift)


def _noted(found: Measurement, ticks: Iterable[Tick]) -> Iterator[Tick]:
    for tick in found.joints.take(ticks):
        found.ticks[tick.kind] = found.ticks.get(tick.kind, 0) + 1
        yield tick
