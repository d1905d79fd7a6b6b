"""Input devices without a person: they ask for the way to a place, and say when it is reached."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from fairlead.messages import FloatArray, Transform, TransformBatch, floats
from fairlead.operate.blocking import BlockingSubscription
from fairlead.operate.tick import Tick
from fairlead_tools.teleop.device import Deflection, Wish
from fairlead_tools.teleop.drive import XYZ, Drive

NEARER = 0.3
"""Of the way that is left, the most that is asked for in one row."""
STALLED_S = 2.0
"""So long without coming nearer, and it is given up."""
LEAST = 0.1
"""Of the tolerance: who comes nearer by so much gets on, however far it still is."""
LATE_S = 0.1
"""A tick's transforms come within a moment of its joints."""
SETTLED = 5
"""Rows for which it stays there, so that what follows late has come to rest."""


class Target:
    """Asks for a straight way along the axes, and quits once there, or once it comes no nearer.

    Args:
        drive: whose axes.
        wanted: per axis where to go, from where the axes are and from now on [rad or m].
        tolerance: per axis how near is there [rad or m].
        speed: share of full speed.
    """

    silence_s = math.inf
    help = "Ctrl-C ends it"

    def __init__(
        self,
        drive: Drive,
        wanted: Callable[[FloatArray], FloatArray],
        tolerance: FloatArray,
        speed: float,
    ) -> None:
        self._drive, self._wanted, self._tolerance = drive, wanted, tolerance
        self._speed = speed
        self._goal: FloatArray | None = None
        self._nearest, self._nearer_s = math.inf, math.inf
        self._settled = 0
        self.is_there = False

    def read(self, now_s: float, at: FloatArray) -> Deflection:
        """As `InputDevice.read`; where the axes are not known, nothing is asked for."""
        self._nearer_s = min(self._nearer_s, now_s)
        if not np.isfinite(at).all():
            return Deflection(axes=(0.0,) * len(at), wish=self._given_up(now_s))
        if self._goal is None:
            self._goal = self._wanted(at)
        left = self._goal - at
        self.is_there = bool((np.abs(left) <= self._tolerance).all())
        self._settled = self._settled + 1 if self.is_there else 0
        far = float(np.max(np.abs(left) / self._tolerance))
        if far < self._nearest - min(LEAST, 0.01 * self._nearest):
            self._nearest, self._nearer_s = far, now_s
        wish: Wish = "quit" if self._settled > SETTLED else self._given_up(now_s)
        share = NEARER * left / (self._drive.full * self._speed)
        share /= max(1.0, float(np.max(np.abs(share))))
        return Deflection(axes=tuple(share), clutch=True, speed=self._speed, wish=wish)

    def _given_up(self, now_s: float) -> Wish:
        return "quit" if now_s - self._nearer_s > STALLED_S else ""


class ToolWay:
    """How far a tool has come since the start, along the axes of the frame it is led in.

    Args:
        heard: transforms of the state assembler.
    """

    def __init__(self, drive: Drive, heard: BlockingSubscription[TransformBatch]) -> None:
        self._names, self._heard = (drive.frame, drive.tool), heard
        self._columns = list(drive.columns)
        self._start: tuple[FloatArray, FloatArray] | None = None

    def __call__(self, tick: Tick) -> FloatArray:
        """Per axis, m and rad (a rotation vector); NaN if the tick's transform does not come."""
        until_s = time.monotonic() + LATE_S  # others' transforms come all the time
        while (left_s := until_s - time.monotonic()) > 0.0:
            if (batch := self._heard.next(left_s)) is None:
                break
            for one in batch.transforms:
                if (one.parent, one.child) == self._names and batch.tick >= tick.number:
                    return self._from_start(one)
        return np.full(len(self._columns), math.nan)

    def _from_start(self, now: Transform) -> FloatArray:
        place, turn = floats(now.translation), floats(now.rotation_xyzw)
        if self._start is None:
            self._start = place, turn
        place_0, turn_0 = self._start
        way = np.concatenate([place - place_0, _rotation_vector(turn, turn_0)])
        return np.asarray(way[self._columns])


def _rotation_vector(xyzw: FloatArray, start_xyzw: FloatArray) -> FloatArray:
    """Of the turn from ``start_xyzw`` to ``xyzw``, in their parent's axes [rad]."""
    v, w = xyzw[:3], xyzw[3]
    v0, w0 = -start_xyzw[:3], start_xyzw[3]
    vector = w * v0 + w0 * v + np.cross(v, v0)
    scalar = w * w0 - float(v @ v0)
    if scalar < 0:
        vector, scalar = -vector, -scalar
    sine = float(np.linalg.norm(vector))
    turn: FloatArray = vector * (2 * math.atan2(sine, scalar) / sine if sine > 1e-12 else 2.0)
    return turn


class BaseWay:
    """How far a base has come since the start, in its own axes then: x, y [m], yaw [rad]."""

    def __init__(self, drive: Drive, base_frame: str) -> None:
        self._names, self._frame = drive.names, base_frame
        self._start: tuple[float, float, float] | None = None
        self._turned = 0.0

    def __call__(self, tick: Tick) -> FloatArray:
        """Per axis of the drive; axes off the floor's plane stay 0."""
        x, y, yaw = tick.planar_pose("odom", self._frame)
        if self._start is None:
            self._start = x, y, yaw
        x0, y0, yaw0 = self._start
        c, s = math.cos(yaw0), math.sin(yaw0)
        ahead, left = c * (x - x0) + s * (y - y0), c * (y - y0) - s * (x - x0)
        self._turned += math.remainder(yaw - yaw0 - self._turned, math.tau)  # over whole turns
        come = {"x": ahead, "y": left, "rz": self._turned}
        return np.array([come.get(name, 0.0) for name in self._names])


def tolerance(drive: Drive, asked: int | None = None) -> FloatArray:
    """How near is there: of joints' targets, a tool or a base [m or rad].

    asked: the one axis that is to move; along the others the robot may come off three times as far.
    """
    near = _near(drive)
    if asked is not None and not drive.is_position:
        near[np.arange(len(near)) != asked] *= 3.0
    return near


def _near(drive: Drive) -> FloatArray:
    if drive.is_position:
        return np.full(len(drive.names), 1e-4)
    if drive.tool:
        return np.array([2e-3 if name in XYZ else 5e-3 for name in drive.names])
    return np.full(len(drive.names), 0.02)
