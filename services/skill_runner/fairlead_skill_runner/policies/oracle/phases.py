"""The oracle's steps from the counter to the cabinet: what each aims at, when it is over.

Heights are in the base frame, whose floor is at -0.90 m; x points ahead of the arm.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from fairlead_skill_runner.policies.oracle.motion import Vector, turn, wrap
from fairlead_skill_runner.policies.oracle.sight import Sight

OPEN, CLOSE = -1.0, 1.0

REACH_M = 0.55
"""How far ahead of the arm's mount the oracle grasps and places."""

HOVER_M = 0.105
"""Grip height above the object's centre before descending."""

GRIP_M = 0.030
"""Grip height above the object's centre when closing; the palm is 31 mm above the grip."""

LIFT_M = 0.13
STAGING_M = 0.40
"""How far in front of its placing position the base lines up with the cabinet."""

OBJECT_BOTTOM_M = 0.050
"""From the object's centre to what it stands on."""

TOUCH_DOWN_M = 0.004
"""Height above the shelf at which the object is let go."""


class Phase(Enum):
    """Steps in order; the value is what feedback and logs show."""

    APPROACH = "drive to the counter"
    ALIGN = "move over the object"
    DESCEND = "descend"
    GRASP = "close the gripper"
    LIFT = "lift"
    TRANSPORT = "drive to the cabinet"
    ENTER = "drive in"
    LOWER = "lower"
    RELEASE = "open the gripper"
    RETREAT = "drive out"
    DONE = "done"


@dataclass(frozen=True)
class Aim:
    """Where a phase wants the robot: base x, y, yaw in odom (None: stay), eef in base."""

    base: Vector | None
    eef: Vector
    gripper: float


@dataclass
class Memory:
    """What the oracle remembers between observations."""

    phase: Phase = Phase.APPROACH
    since_tick: int = 0
    home_yaw: float = 0.0
    carry: Vector = field(default_factory=lambda: np.zeros(3))
    grasp_odom: Vector = field(default_factory=lambda: np.zeros(2))
    grasp_height: float = 0.0
    hand: Vector = field(default_factory=lambda: np.zeros(3))
    place: Vector = field(default_factory=lambda: np.zeros(3))
    exit_base: Vector = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Motion:
    """Speeds the oracle believes in: eef [m/s] in base, base [m/s, m/s, rad/s] in odom."""

    eef: Vector
    base: Vector

    @property
    def eef_slow(self) -> bool:
        """Whether the hand moves by less than 0.04 m/s."""
        return bool(np.linalg.norm(self.eef) < 0.04)

    @property
    def base_slow(self) -> bool:
        """Whether the base moves by less than 0.04 m/s or rad/s on every axis."""
        return bool(np.abs(self.base).max() < 0.04)


def aim(memory: Memory, sight: Sight) -> Aim:
    """Where the current phase wants the robot."""
    return _AIMS[memory.phase](memory, sight)


def advance(memory: Memory, sight: Sight, motion: Motion) -> None:
    """Go on to the next phases whose predecessors are over."""
    while _over(memory, sight, motion):
        if memory.phase is Phase.LIFT and not holds(sight):
            enter(memory, Phase.ALIGN, sight)
            return
        order = list(Phase)
        enter(memory, order[order.index(memory.phase) + 1], sight)


def begun(first: Phase, sight: Sight) -> Memory:
    """Memory of one that begins with ``first``, whatever brought the robot there."""
    memory = Memory(since_tick=sight.tick, home_yaw=float(sight.base[2]))
    memory.grasp_height = float(sight.eef[2]) - GRIP_M - LIFT_M
    if is_after(first, Phase.LIFT):
        enter(memory, Phase.TRANSPORT, sight)
    enter(memory, first, sight)
    return memory


def is_after(phase: Phase, other: Phase) -> bool:
    """Whether it comes later in the task."""
    order = list(Phase)
    return order.index(phase) > order.index(other)


def enter(memory: Memory, phase: Phase, sight: Sight) -> None:
    """Begin a phase: keep what it aims at."""
    memory.phase, memory.since_tick = phase, sight.tick
    if phase is Phase.DESCEND:
        # Frozen: closing fingers hide and nudge the object.
        memory.grasp_odom, memory.grasp_height = sight.obj_odom, float(sight.obj[2])
    if phase in (Phase.GRASP, Phase.LIFT, Phase.RELEASE):
        memory.hand = sight.eef.copy()
    if phase is Phase.TRANSPORT:
        memory.carry = np.array([REACH_M - 0.03, 0.0, memory.grasp_height + GRIP_M + LIFT_M])
    if phase is Phase.LOWER:
        drop = sight.obj[2] - OBJECT_BOTTOM_M - sight.goal[2] - TOUCH_DOWN_M
        offset = sight.eef - sight.obj
        memory.place = np.append(sight.goal[:2] + offset[:2], sight.eef[2] - drop)
    if phase is Phase.RETREAT:
        memory.exit_base = before_cabinet(sight, STAGING_M)


def _over(memory: Memory, sight: Sight, motion: Motion) -> bool:
    age = sight.tick - memory.since_tick
    target = aim(memory, sight)
    error = target.eef - sight.eef
    lateral, height = float(np.linalg.norm(error[:2])), float(abs(error[2]))
    arrived = target.base is not None and _base_there(target.base, sight, motion)
    if memory.phase is Phase.APPROACH:
        return arrived
    if memory.phase is Phase.ALIGN:
        return lateral < 0.008 and height < 0.02 and motion.eef_slow
    if memory.phase is Phase.DESCEND:
        return (height < 0.008 and motion.eef_slow) or age >= 60
    if memory.phase in (Phase.GRASP, Phase.RELEASE):
        return age >= 12
    if memory.phase is Phase.LIFT:
        return height < 0.03 or age >= 40
    if memory.phase in (Phase.TRANSPORT, Phase.ENTER):
        return arrived
    if memory.phase is Phase.LOWER:
        return (height < 0.006 and lateral < 0.02 and motion.eef_slow) or age >= 60
    return memory.phase is Phase.RETREAT and arrived


def _base_there(target: Vector, sight: Sight, motion: Motion) -> bool:
    offset = target - sight.base
    return bool(
        np.linalg.norm(offset[:2]) < 0.02 and abs(wrap(offset[2])) < 0.02 and motion.base_slow
    )


def holds(sight: Sight) -> bool:
    """Whether the object is where the fingers would hold it."""
    return bool(np.linalg.norm(sight.obj - sight.eef) < 0.05 and sight.opening > 0.02)


def before_cabinet(sight: Sight, back_off: float) -> Vector:
    """Base pose from which the goal is straight ahead, ``back_off`` beyond reach."""
    ahead = turn(sight.goal_yaw) @ np.array([REACH_M + back_off, 0.0])
    return np.append(sight.goal_odom - ahead, sight.goal_yaw)


def _hover(sight: Sight) -> Vector:
    return np.asarray(sight.obj + np.array([0.0, 0.0, HOVER_M]))


def _approach(memory: Memory, sight: Sight) -> Aim:
    ahead = turn(memory.home_yaw) @ np.array([REACH_M, 0.0])
    height = sight.obj[2] + HOVER_M
    return Aim(
        np.append(sight.obj_odom - ahead, memory.home_yaw), np.array([REACH_M, 0.0, height]), OPEN
    )


def _align(memory: Memory, sight: Sight) -> Aim:
    return Aim(None, _hover(sight), OPEN)


def _descend(memory: Memory, sight: Sight) -> Aim:
    height = memory.grasp_height + GRIP_M
    return Aim(None, np.append(sight.in_base(memory.grasp_odom), height), OPEN)


def _grasp(memory: Memory, sight: Sight) -> Aim:
    return Aim(None, memory.hand, CLOSE)


def _lift(memory: Memory, sight: Sight) -> Aim:
    return Aim(None, memory.hand + np.array([0.0, 0.0, LIFT_M]), CLOSE)


def _transport(memory: Memory, sight: Sight) -> Aim:
    return Aim(before_cabinet(sight, STAGING_M), memory.carry, CLOSE)


def _enter_cabinet(memory: Memory, sight: Sight) -> Aim:
    return Aim(before_cabinet(sight, 0.0), memory.carry, CLOSE)


def _lower(memory: Memory, sight: Sight) -> Aim:
    return Aim(None, memory.place, CLOSE)


def _release(memory: Memory, sight: Sight) -> Aim:
    return Aim(None, memory.hand, OPEN)


def _retreat(memory: Memory, sight: Sight) -> Aim:
    return Aim(memory.exit_base, memory.hand + np.array([0.0, 0.0, 0.03]), OPEN)


def _done(memory: Memory, sight: Sight) -> Aim:
    return Aim(None, memory.hand + np.array([0.0, 0.0, 0.03]), OPEN)


_AIMS: dict[Phase, Callable[[Memory, Sight], Aim]] = {
    Phase.APPROACH: _approach,
    Phase.ALIGN: _align,
    Phase.DESCEND: _descend,
    Phase.GRASP: _grasp,
    Phase.LIFT: _lift,
    Phase.TRANSPORT: _transport,
    Phase.ENTER: _enter_cabinet,
    Phase.LOWER: _lower,
    Phase.RELEASE: _release,
    Phase.RETREAT: _retreat,
    Phase.DONE: _done,
}
