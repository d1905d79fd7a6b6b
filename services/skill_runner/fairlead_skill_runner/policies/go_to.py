"""GoToPolicy: bring a mobile base to a pose. Turn, drive straight, turn; nothing else."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.modes import ControlMode
from fairlead.policy import Actions, Done, Failed, Observation
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.surroundings import BaseSurroundings, zone_breach
from fairlead.skill.manifest import SkillManifest

LAYOUT = "base_pose_6d"
GOAL_FORM = "'x y yaw' [m, m, rad] in plain numbers, such as 0.5 -1 1.57"
ACCELERATION = np.array([0.5, 1.0])
"""Most that the rates ahead [m/s] and to the left [rad/s] change in a second."""
GAIN_HZ = 2.0
"""Rate per distance left: the base follows a little later than it is told."""
AHEAD_RAD = 0.05
"""It drives once the goal lies this straight ahead, and steers while it drives ..."""
ASTRAY_RAD = 0.5
"""... until it is off by so much: then it stands still and turns again."""
STILL = 1e-3
"""Motion in one control period [m, rad] that counts as standing still."""

Pose = tuple[float, float, float]


class GoToOptions(BaseModel):
    """How near to the goal is there: in place and in yaw."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    tolerance_m: float = Field(default=0.03, ge=0.005, le=0.5)
    tolerance_rad: float = Field(default=0.03, ge=0.005, le=0.5)


class Phase(Enum):
    """What the base does."""

    TURN_AHEAD = "turns towards the goal"
    DRIVE = "drives straight"
    TURN_FINAL = "turns to the goal's yaw"


@dataclass(frozen=True)
class Motion:
    """Where the base is or will be in one tick, what it does there, and its rates.

    pose: x [m], y [m], yaw [rad]. ahead, left: m/s and rad/s.
    """

    pose: Pose
    phase: Phase = Phase.TURN_AHEAD
    ahead: float = 0.0
    left: float = 0.0


class GoToPolicy:
    """Output rows (float32, 2 wide): ahead and to the left, each in [-1, 1] of its scale.

    The first answer checks the goal: a prompt that is no pose, and a pose at which the
    base would breach a zone, fail before anything moves.

    Args:
        scale: fastest [m/s, rad/s].
        base: what the robot's safety profile says of its base and zones.
    """

    def __init__(
        self,
        options: GoToOptions,
        scale: tuple[float, float],
        skill: SkillManifest,
        base: BaseSurroundings,
    ) -> None:
        self._options, self._scale, self._base = options, scale, base
        self._horizon = skill.horizon
        self._period_s = 1.0 / skill.rate_hz
        self._frame = skill.state_contract.bindings.world_frame
        self.reset()

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises `ConfigError` for options or contracts that do not fit."""
        check_go_to(skill, options)

    @classmethod
    def for_robot(
        cls,
        skill: SkillManifest,
        options: Mapping[str, JsonValue],
        robot: RobotManifest,
        profile: str,
    ) -> Self:
        """Raises `ConfigError` for what does not fit, also a robot without a mobile base."""
        checked, scale = check_go_to(skill, options)
        base = robot.profile(profile).base
        if base is None:
            raise ConfigError(f"go_to policy: robot {robot.id} has no mobile base with zones")
        return cls(checked, scale, skill, base)

    def reset(self) -> None:
        """Forget the goal and the way."""
        self._goal: Pose | None = None
        self._seen: tuple[int, Pose] | None = None
        self._plan: dict[int, Motion] = {}  # by row of the newest answer
        self._plan_tick = 0  # of that answer

    def infer(self, observation: Observation) -> Actions | Done | Failed:
        """One chunk ``[horizon, 2]`` from a state of layout ``base_pose_6d``, or the end."""
        state = [float(number) for number in observation.state]
        if len(state) != 6:
            raise PolicyError(expected("go_to", "a state of 6 numbers", len(state)))
        pose, odom = (state[0], state[1], state[2]), (state[3], state[4], state[5])
        if self._goal is None:
            problem = self._take_goal(observation.prompt, pose, odom)
            if problem is not None:
                return problem
        assert self._goal is not None
        still = self._is_still(observation.tick, pose)
        if still and self._is_there(pose):
            x, y, yaw = pose
            return Done(f"the base is at {x:.2f} {y:.2f} {yaw:.2f} in {self._frame}")
        if any(part.hold for part in observation.executed.values()):
            self._plan = {}  # nothing of it acts
        acting = (observation.tick - 1 - self._plan_tick) // observation.periods
        self._plan_tick = observation.tick
        return self._rows(acting, pose)

    # --- the goal --------------------------------------------------------------------

    def _take_goal(self, prompt: str, pose: Pose, odom: Pose) -> Failed | None:
        numbers = read_pose(prompt)
        if numbers is None:
            who = f"go_to: a goal in {self._frame}"
            return Failed("bad_goal", expected(who, GOAL_FORM, repr(prompt)))
        breach = zone_breach(self._base, *_carried_over(numbers, pose, odom))
        if breach:
            return Failed("goal_outside_zones", f"at {prompt.strip()} the base would be {breach}")
        self._goal = numbers
        return None

    def _is_there(self, pose: Pose) -> bool:
        assert self._goal is not None
        x, y, yaw = self._goal
        near = math.hypot(x - pose[0], y - pose[1]) <= self._options.tolerance_m
        return near and abs(wrap(yaw - pose[2])) <= self._options.tolerance_rad

    def _is_still(self, tick: int, pose: Pose) -> bool:
        before, self._seen = self._seen, (tick, pose)
        if before is None:
            return True  # nothing of this goal has moved it
        ticks = max(1, tick - before[0])
        moved = max(
            math.hypot(pose[0] - before[1][0], pose[1] - before[1][1]),
            abs(wrap(pose[2] - before[1][2])),
        )
        return moved <= STILL * ticks

    # --- the way ---------------------------------------------------------------------

    def _rows(self, acting: int, pose: Pose) -> Actions:
        """Goes on from the rates of its own plan in the row that acts, at the measured pose."""
        now = replace(self._plan.get(acting, Motion(pose)), pose=pose)
        rows = np.zeros((self._horizon, 2), dtype=np.float32)
        self._plan = {}
        for row in range(self._horizon):
            now = self._next(now)
            self._plan[row] = now
            rows[row] = now.ahead / self._scale[0], now.left / self._scale[1]
        return rows

    def _next(self, now: Motion) -> Motion:
        """The rates of one control period, and the pose that they lead to."""
        assert self._goal is not None
        phase, way_m, turn_rad = self._aim(now)
        ahead = self._rate(0, now.ahead, way_m)
        left = self._rate(1, now.left, turn_rad)
        x, y, yaw = now.pose
        dt = self._period_s
        x, y = x + ahead * math.cos(yaw) * dt, y + ahead * math.sin(yaw) * dt
        return Motion((x, y, wrap(yaw + left * dt)), phase, ahead, left)

    def _aim(self, now: Motion) -> tuple[Phase, float, float]:
        """What to do now: the phase, how far to drive [m] and to turn [rad]."""
        assert self._goal is not None
        x, y, goal_yaw = self._goal
        dx, dy, yaw = x - now.pose[0], y - now.pose[1], now.pose[2]
        away_m, turn_rad = math.hypot(dx, dy), wrap(math.atan2(dy, dx) - yaw)
        tolerance_m = self._options.tolerance_m
        is_final = now.phase is Phase.TURN_FINAL
        if away_m <= (tolerance_m if is_final else tolerance_m / 2):
            turn_rad = wrap(goal_yaw - yaw)
            near = abs(turn_rad) <= self._options.tolerance_rad / 2  # to and fro would never end
            return Phase.TURN_FINAL, 0.0, 0.0 if near else turn_rad
        driving = now.phase is Phase.DRIVE and abs(turn_rad) < ASTRAY_RAD
        if driving or (abs(turn_rad) < AHEAD_RAD and abs(now.left) < AHEAD_RAD):
            steer = turn_rad if away_m > 4 * tolerance_m else 0.0
            return Phase.DRIVE, away_m * math.cos(turn_rad), steer
        return Phase.TURN_AHEAD, 0.0, turn_rad

    def _rate(self, axis: int, before: float, left: float) -> float:
        """Towards ``left``, as fast as scale, acceleration and the way to brake allow."""
        most = min(
            self._scale[axis], GAIN_HZ * abs(left), math.sqrt(2 * ACCELERATION[axis] * abs(left))
        )
        change = float(ACCELERATION[axis]) * self._period_s
        return float(np.clip(math.copysign(most, left), before - change, before + change))


def check_go_to(
    skill: SkillManifest, options: Mapping[str, JsonValue]
) -> tuple[GoToOptions, tuple[float, float]]:
    """The options, and the scale of the skill's twist [m/s, rad/s].

    Raises:
        ConfigError: for options, a layout or an action contract that do not fit.
    """
    who = "go_to policy"
    checked = checked_model(who, GoToOptions, options)
    if skill.state_contract.layout != LAYOUT:
        raise ConfigError(expected(who, f"layout {LAYOUT}", skill.state_contract.layout))
    slots = skill.action_contract.routed
    if len(slots) != 1 or (slots[0].mode, slots[0].axes) != (ControlMode.BODY_TWIST, (0, 5)):
        got = ", ".join(slot.name for slot in slots)
        raise ConfigError(expected(who, "one slot, body_twist of axes [0, 5]", got))
    ahead, left = slots[0].scales()
    return checked, (ahead, left)


def read_pose(text: str) -> Pose | None:
    """The x [m], y [m] and yaw [rad] of a prompt; None if it is anything but three numbers."""
    number = r"([-+]?\d{1,6}(?:\.\d{1,12})?)"
    found = re.fullmatch(rf"\s*{number}\s+{number}\s+{number}\s*", text)
    if found is None:
        return None
    x, y, yaw = (float(group) for group in found.groups())
    return x, y, yaw


def wrap(angle_rad: float) -> float:
    """The same angle in [-pi, pi]."""
    return math.remainder(angle_rad, 2 * math.pi)


def _carried_over(goal: Pose, pose: Pose, odom: Pose) -> Pose:
    """A goal of the frame in which the base is at ``pose``, in that where it is at ``odom``."""
    turned = odom[2] - pose[2]
    dx, dy = goal[0] - pose[0], goal[1] - pose[1]
    cos, sin = math.cos(turned), math.sin(turned)
    return odom[0] + cos * dx - sin * dy, odom[1] + sin * dx + cos * dy, goal[2] + turned
