"""A robot without physics: it makes of each row the share it is told to, and brakes as declared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.soundness.prediction import TARGETS, Prediction
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment, Tick

AT_ONCE = 1e9
"""Deceleration of a joint that declares none [rad/s^2 or m/s^2]."""
AT_REST_S = 1e3
"""Everything has come to rest by then."""


@dataclass(frozen=True)
class Faults:
    """What is not as declared.

    sag: how far each joint comes to rest from its target, ``[n_dof]`` [rad or m]. is_stuck: every
    velocity is measured as 0.
    """

    sag: FloatArray | float = 0.0
    is_stuck: bool = False


class ShareRobot:
    """Stands in for a `DrivenRobot` in a `GateLoop`. Positions are of every measured joint.

    What holds, and a base that is told 0, goes on for its stop lag and reaction time, then slows
    down as declared; or only a share of that.

    Args:
        file: the robot's gate file, for gains, stop lags and decelerations.

    Attributes:
        share: of each part, in the newest tick.
        told: where the newest row that acted would have led without sag.
    """

    def __init__(self, robot: RobotManifest, file: dict[str, Any]) -> None:
        self.robot, self._period_s = robot, robot.tick_period_ns * 1e-9
        self.prediction = Prediction(robot, file)
        joints, base, names = file["joints"], file["base"], robot.joint_names
        self._own = [(part.name, [names.index(n) for n in part.joints]) for part in robot.parts]
        self.base = [names.index(name) for name in base["joints"]] if base else []
        self._react_s = np.zeros(len(joints))
        self._react_s[self.base] = base["reaction_s"] if base else 0.0
        self._lag_s = np.array([joint.get("stop_lag") or 0.0 for joint in joints])
        self._fastest = np.array([joint.get("velocity_limit") or np.inf for joint in joints])
        self._slowing = np.array([joint.get("acceleration_limit") or AT_ONCE for joint in joints])

    def begin(
        self, positions: FloatArray, shares: FloatArray, faults: Faults | None = None
    ) -> None:
        """Stand there. shares: of each tick and part, as in `Prediction.follow`."""
        self._positions, self._shares, self._tick = positions, shares, 0
        self._faults, self.told = faults or Faults(), positions
        self._speeds, self._waits_s = np.zeros((2, len(self._lag_s)))
        self.prediction.forget_goals()

    def reset(self, seed: int) -> Moment:
        """Where it was told to begin."""
        return self._moment(self._positions)

    def step(self, kind: str, before: Moment, commands: Mapping[str, PartCommand]) -> Tick:
        """One tick with these rows; what has none holds."""
        self.share, self._tick = self._shares[self._tick], self._tick + 1
        [after] = self.prediction.follow(before.positions, [commands], self.share[None])
        if commands:
            self.told = after.copy()
        way, speeds = self._braking(self._period_s)
        for (part, own), share in zip(self._own, self.share, strict=True):
            command = commands.get(part)
            if command is None or (own == self.base and not command.values.any()):
                after[own] += share * way[own]
                self._speeds[own] = share * speeds[own]
                self._waits_s[own] = np.maximum(self._waits_s[own] - self._period_s, 0.0)
                continue
            is_target = command.mode in (*TARGETS, ControlMode.CARTESIAN_POSE)
            if is_target:
                after[own] += np.broadcast_to(self._faults.sag, self._speeds.shape)[own]
            self._speeds[own] = (after - before.positions)[own] / self._period_s
            self._waits_s[own] = self._react_s[own] + (0.0 if is_target else self._lag_s[own])
        return Tick(kind, before, self._moment(after), commands, is_free=True)

    def stopped(self, done: Tick, shares: FloatArray | None = None) -> FloatArray:
        """Where it comes to rest if it is told to hold after this tick.

        Args:
            shares: of each joint's way, of a base's first joint for the base; None: all of it.
        """
        end, way = done.after.positions.copy(), self._braking(AT_REST_S)[0]
        if shares is not None:
            shares[self.base] = shares[self.base[:1]]
            way = shares * way
        for _, own in self._own:
            end[own] += way[own]
        return end

    def base_speed(self) -> float:
        """Of its fastest joint, in that one's limit; 0 without a base."""
        share = np.abs(self._speeds[self.base]) / self._fastest[self.base]
        return float(share.max(initial=0.0))

    def _braking(self, seconds: float) -> tuple[FloatArray, FloatArray]:
        """How far each joint goes on in that time, and how fast it is then."""
        speed = np.minimum(np.abs(self._speeds), self._fastest)
        goes_on_s = np.minimum(self._waits_s, seconds)
        slows_s = np.minimum(seconds - goes_on_s, speed / self._slowing)
        lost = self._slowing * slows_s
        way = speed * (goes_on_s + slows_s) - 0.5 * lost * slows_s
        sign = np.sign(self._speeds)
        return sign * way, sign * (speed - lost)

    def _moment(self, positions: FloatArray) -> Moment:
        velocities = np.zeros(len(positions))
        if not self._faults.is_stuck:
            velocities[: len(self._speeds)] = self._speeds
        return Moment(positions, velocities, np.zeros(len(positions)), {}, np.zeros(3))
