"""How the simulated robot answers the oracle's commands, and the laws that use it.

Chunks are computed every few ticks, so the rows after the first need a prediction of
where the robot will be by then. Constants were measured on the simulator's PandaOmron.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]

TICK_S = 0.05

ARM_STIFFNESS = 150.0
"""Operational-space stiffness [1/s^2]; the damping ratio is 1."""

ARM_FULL_SCALE = np.array([0.05, 0.05, 0.05, 0.5, 0.5, 0.5])
"""Arm delta at output +-1: metres and radians."""

ARM_GAIN = 1.2
"""Share of the remaining way that is commanded as a delta in one tick."""

HAND_STEP_M = 0.065
"""Most that the hand is told to move in a tick, in any direction: two axes at full scale ask more
of a joint than it may do, where an episode begins with all joints half-way."""

BASE_FULL_SCALE = np.array([1.0, 1.0, 1.5])
"""Base joint rate at output +-1: m/s, m/s, rad/s."""

BASE_DEAD_BAND = np.array([0.25, 0.25, 1.0 / 6.0])
"""Rate each base joint loses to dry friction [m/s, m/s, rad/s]."""

BASE_RESPONSE = np.array([0.62, 0.62, 1.0])
"""Share of a change in rate that is reached after one tick."""

BASE_GAIN_HZ = np.array([3.0, 3.0, 3.0])
BASE_SPEED = np.array([0.55, 0.55, 0.50])
"""Fastest the oracle drives [m/s, m/s] and turns [rad/s]: faster, the arm lags."""

BASE_SPEED_STEP = np.array([0.12, 0.12, 0.20])
"""Largest change of the wanted rate per tick."""

BASE_CLOSE = np.array([0.008, 0.008, 0.006])
"""Errors [m, m, rad] below which a base joint is told to stand still."""


def turn(angle: float) -> Vector:
    """Plane rotation by ``angle`` [rad], shape ``[2, 2]``."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def wrap(angle: float) -> float:
    """The same angle in (-pi, pi]."""
    return float(-((np.pi - angle) % (2 * np.pi) - np.pi))


@dataclass
class ArmModel:
    """End effector in the base frame: position or rotation vector [3], and its rate.

    Between ticks the goal is fixed and the error decays critically damped; every tick
    the goal is set anew from the achieved pose.
    """

    position: Vector
    velocity: Vector

    def advance(self, delta: Vector) -> None:
        """One tick with ``delta`` [m or rad] commanded."""
        omega = np.sqrt(ARM_STIFFNESS)
        decay = np.exp(-omega * TICK_S)
        slope = self.velocity - omega * delta
        error = (-delta + slope * TICK_S) * decay
        self.velocity = slope * decay - omega * error
        self.position = self.position + delta + error


@dataclass
class DriveModel:
    """Base pose x, y [m], yaw [rad] in odom, and its rates."""

    pose: Vector
    velocity: Vector
    wanted: Vector

    def advance(self, rates: Vector) -> None:
        """One tick with the wanted ``rates`` (after friction) in odom."""
        before = self.velocity
        self.velocity = before + BASE_RESPONSE * (rates - before)
        # A rate that changes at once acts for the whole tick, a slow one on average.
        share = (1 + BASE_RESPONSE) / 2
        self.pose = self.pose + TICK_S * (share * self.velocity + (1 - share) * before)


def base_rates(model: DriveModel, target: Vector | None) -> Vector:
    """Rates in odom towards ``target`` (x, y, yaw), gentle at both ends."""
    rates = np.zeros(3)
    if target is not None:
        error = target - model.pose
        error[2] = wrap(error[2])
        rates = BASE_GAIN_HZ * error
        distance = np.linalg.norm(rates[:2])
        if distance > BASE_SPEED[0]:
            rates[:2] *= BASE_SPEED[0] / distance
        rates[2] = np.clip(rates[2], -BASE_SPEED[2], BASE_SPEED[2])
        rates[np.abs(error) < BASE_CLOSE] = 0.0
    step = np.clip(rates - model.wanted, -BASE_SPEED_STEP, BASE_SPEED_STEP)
    return np.asarray(np.where(rates == 0.0, 0.0, model.wanted + step))


def base_output(rates: Vector, yaw: float) -> Vector:
    """Policy output in [-1, 1] that makes the base move at ``rates`` in odom.

    The simulator turns commands back by the yaw since its reset, where odom's axes are
    the base's; so they are turned forward here.
    """
    lifted = rates + np.where(np.abs(rates) > 1e-3, np.sign(rates), 0.0) * BASE_DEAD_BAND
    command = np.append(turn(yaw) @ lifted[:2], lifted[2]) / BASE_FULL_SCALE
    return np.asarray(np.clip(command, -1.0, 1.0))


def hand_delta(way: Vector) -> Vector:
    """``way`` [m], no longer than `HAND_STEP_M`."""
    return way * (HAND_STEP_M / max(float(np.linalg.norm(way)), HAND_STEP_M))


def arm_drag(yaw_rate: float, eef: Vector) -> Vector:
    """Delta [m] that cancels how far the end effector trails while the base turns.

    The controller damps the end effector's velocity beyond that of the base's centre, so
    a turn drags it behind by damping over stiffness times the velocity of its swing.
    """
    lag_s = 2.0 / np.sqrt(ARM_STIFFNESS)
    return np.asarray(lag_s * yaw_rate * np.array([-eef[1], eef[0], 0.0]))
