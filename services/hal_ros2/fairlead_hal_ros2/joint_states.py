"""The newest state of each joint, from `sensor_msgs/JointState`, whoever publishes which."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fairlead.errors import MessageError, expected
from fairlead.hal.backend import Measurement
from fairlead.ros2.messages import stamp_ns_of

WINDOW_S = 30.0
_DAY_S = 86_400.0


class Lateness:
    """How much later a sender's messages come than the soonest of the last minute.

    So one that has waited on its way is old when it arrives. The sender's clock may be wrong, but
    not by a day: stamps of a simulation's clock say nothing.
    """

    def __init__(self) -> None:
        self._soonest_s, self._before_s, self._began_s = math.inf, math.inf, -math.inf

    def of(self, stamp_ns: int, now_s: float) -> float:
        """Of a message [s]; 0 without a stamp of today."""
        stamp_s = stamp_ns * 1e-9
        if abs(time.time() - stamp_s) > _DAY_S:
            return 0.0
        delay_s = now_s - stamp_s
        if now_s - self._began_s > WINDOW_S:
            self._before_s, self._soonest_s, self._began_s = self._soonest_s, math.inf, now_s
        self._soonest_s = min(self._soonest_s, delay_s)
        return delay_s - min(self._soonest_s, self._before_s)


@dataclass(frozen=True)
class Reading:
    """One joint, [rad or m], [rad/s or m/s], [N m or N]; nan where its message has no number.

    stamp_ns: its sender's clock, 0: not said; arrived_s: this process's, when it came or would
    have, had it not waited on its way.
    """

    position: float
    velocity: float
    effort: float
    stamp_ns: int
    arrived_s: float


class JointStates:
    """Readings by the names that joints have in the ROS 2 system.

    Several may publish on the topic, each its own joints.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._newest: dict[str, Reading] = {}
        self._lateness: dict[str, Lateness] = {}

    def take(self, message: Any, now_s: float) -> None:
        """Keep what is new; a reading that is stamped as the one before is none.

        Args:
            message: a `JOINT_STATE`.

        Raises:
            MessageError: lists of different lengths, or a position that is no finite number.
        """
        names, stamp_ns = list(message.name), stamp_ns_of(message.header)
        position, velocity, effort = (
            _column(field, getattr(message, field), names)
            for field in ("position", "velocity", "effort")
        )
        if not np.isfinite(position).all():
            raise MessageError(expected("position", "finite numbers", position))
        with self._lock:
            for name, *row in zip(names, position, velocity, effort, strict=True):
                before = self._newest.get(name)
                if before is None or stamp_ns == 0 or stamp_ns > before.stamp_ns:
                    late_s = self._lateness.setdefault(name, Lateness()).of(stamp_ns, now_s)
                    self._newest[name] = Reading(row[0], row[1], row[2], stamp_ns, now_s - late_s)

    def newest(self) -> Mapping[str, Reading]:
        """The newest reading of each joint."""
        with self._lock:
            return dict(self._newest)


def _column(field: str, values: Sequence[float], names: Sequence[str]) -> list[float]:
    if len(values) == len(names):
        return [float(value) for value in values]
    if field != "position" and len(values) == 0:
        return [math.nan] * len(names)
    raise MessageError(expected(field, f"{len(names)} numbers, as many as names", len(values)))


@dataclass(frozen=True)
class JointSource:
    """What a joint of robot.yaml is in the ROS 2 system: a weighted sum of joints.

    Attributes:
        factors: by the joint's name there.
        has_effort: whether somebody measures it.
    """

    joint: str
    factors: Mapping[str, float]
    has_effort: bool

    def problem(self, readings: Mapping[str, Reading]) -> str:
        """What is missing for `measure`; "" if nothing is."""
        for name in self.factors:
            reading = readings.get(name)
            if reading is None:
                return f"joint {name!r} is missing"
            if not np.isfinite(reading.velocity):
                return f"joint {name!r} has no velocity"
            if self.has_effort and not np.isfinite(reading.effort):
                return (
                    f"joint {name!r} has no effort, so the gate could not feel a contact; if "
                    f"nothing measures it, add {self.joint} to the option without_effort"
                )
        return ""

    def measure(self, readings: Mapping[str, Reading]) -> tuple[float, float, float]:
        """Position, velocity and effort: what of the joints' efforts moves along `shares`."""
        pairs = [(factor, readings[name]) for name, factor in self.factors.items()]
        whole = sum(factor**2 for factor in self.factors.values())
        told = sum(factor * one.effort for factor, one in pairs) if self.has_effort else 0.0
        return (
            sum(factor * one.position for factor, one in pairs),
            sum(factor * one.velocity for factor, one in pairs),
            told / whole,
        )

    def shares(self, position: float) -> list[float]:
        """Where each of the joints there has to go for a position, by the smallest way."""
        whole = sum(factor**2 for factor in self.factors.values())
        return [position * factor / whole for factor in self.factors.values()]


def age_s(sources: Iterable[JointSource], readings: Mapping[str, Reading], now_s: float) -> float:
    """Age of the oldest of the newest readings that these joints are made of [s]."""
    return max(now_s - readings[name].arrived_s for source in sources for name in source.factors)


def measurement(
    sources: Sequence[JointSource | None],
    readings: Mapping[str, Reading],
    others: Mapping[int, tuple[float, float]],
) -> Measurement:
    """All joints of a robot in wire order.

    Args:
        sources: None for a joint that is in ``others``.
        others: position and velocity by the joint's index; nobody measures its effort.
    """
    rows = [
        (*others[index], 0.0) if source is None else source.measure(readings)
        for index, source in enumerate(sources)
    ]
    return Measurement(*np.array(rows, dtype=float).T)
