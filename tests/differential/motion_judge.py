"""G040, G041, G042: measured motion against the rows that acted, from docs/safety-checks.md."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np
import pinocchio

from bench.equipment.case import Measured, PartRows
from bench.equipment.kinematics import angle_between, rotation_of
from fairlead.messages import FloatArray
from tests.differential.changes import speed_of
from tests.differential.gate_file import Block, GateFile, Part
from tests.differential.stuck_judge import StuckJudge

TARGETS = (0, 11)
VELOCITY, POSE, DELTA, TWIST, BODY = 1, 4, 5, 6, 7
HALVES = (DELTA, TWIST, BODY)
CLOSED, OPENING = 9, 10
STATES_TO_HOLD = 3


@dataclass(frozen=True)
class Told:
    """One part's row. values: ``[width]``."""

    mode: int
    frame: str
    active: tuple[int, ...]
    values: FloatArray


def told(rows: PartRows, row: int) -> Told:
    return Told(rows.mode, rows.frame, rows.active, rows.values[row])


@dataclass(frozen=True)
class Finding:
    """code: 0 if nothing stops. nearness: how near the closest comparison was, of its limit."""

    code: int = 0
    axis: str = ""
    nearness: float = math.inf


@dataclass
class MotionJudge:
    """What one part of an armed gate remembers from state to state."""

    file: GateFile
    limits: dict[str, dict[str, float]]
    period_s: float
    root: str
    part: Part
    before: Told | None = None
    stuck: StuckJudge = field(init=False)
    target: float | None = None
    told_at: float = math.nan
    goes: bool = False
    still: int = 0
    gripped: float | None = None

    def __post_init__(self) -> None:
        self.stuck = StuckJudge(
            self.part.joints,
            {j: self._of(j, "encoder_step") for j in self.part.joints},
            {j: self._of(j, "dead_band") for j in self.part.joints},
            self._part_band(),
            self.file.protocol["stuck_ticks"],
        )

    def _part_band(self) -> tuple[float, float]:
        """ "Of a slide in metres", of a turning joint in radians and as it moves the tool."""
        bands = {j: self._of(j, "dead_band") for j in self.part.joints}
        turning = {j for j in bands if not self.file.joints[j].slides}
        ways = [bands[j] * (self.part.levers.get(j, 0.0) if j in turning else 1.0) for j in bands]
        return max(ways, default=0.0), max((bands[j] for j in turning), default=0.0)

    def judge(self, row: Told | None, last: Measured, now: Measured) -> Finding:
        """The newest state after ``row`` acted on the part (None: it held)."""
        findings = [self._grasp(row, last, now)]
        self.stuck.note(last, now)
        if row is not None:
            findings += [self._tracking(row, last, now), self._stuck(row, now)]
        self.before = row
        nearness = min(found.nearness for found in findings)
        first = next((found for found in findings if found.code), findings[0])
        return replace(first, nearness=nearness)

    # --- G040 ---

    def _tracking(self, row: Told, last: Measured, now: Measured) -> Finding:
        if row.mode in TARGETS:
            errors = [(j, abs(now.positions[j] - row.values[j])) for j in row.active]
            return self._worst_joint(row, errors)
        if row.mode == VELOCITY:
            off = [(j, self._off_speed(row, j, last, now)) for j in row.active]
            return self._worst_joint(row, off)
        if row.mode == POSE:
            place, turn = self._pose(now, row.frame)
            away = float(np.linalg.norm(place - row.values[:3]))
            return self._worst_half(row, away, angle_between(turn, rotation_of(row.values[3:])))
        if row.mode in HALVES:
            linear, angular = (
                distance_to_hull(motion, self._allowed(row, last, half))
                for half, motion in zip((0, 3), self._moved(row, last, now), strict=True)
            )
            return self._worst_half(row, linear, angular)
        return Finding()

    def _off_speed(self, row: Told, j: int, last: Measured, now: Measured) -> float:
        lower, upper = self._block(row)["gain"]
        speeds = [lower * row.values[j], upper * row.values[j]]
        if self._goes_on(row) and self.before is not None and j in self.before.active:
            speeds += [lower * self.before.values[j], upper * self.before.values[j]]
        else:
            speeds += [0.0, last.velocities[j]]
        speed = float(now.velocities[j])
        return float(max(min(speeds) - speed, speed - max(speeds), 0.0))

    def _allowed(self, row: Told, last: Measured, half: int) -> list[FloatArray]:
        """Corners of the motions that the tracking model allows."""
        lower, upper = self._block(row)["gain"]
        asked = row.values[half : half + 3]
        corners = [lower * asked, upper * asked]
        if self._goes_on(row) and self.before is not None:
            asked = self.before.values[half : half + 3]
            return [*corners, lower * asked, upper * asked]
        return [*corners, np.zeros(3), self._motion_when_begun(row, last)[half : half + 3]]

    def _goes_on(self, row: Told) -> bool:
        before = self.before
        return before is not None and (before.mode, before.frame) == (row.mode, row.frame)

    def _motion_when_begun(self, row: Told, last: Measured) -> FloatArray:
        if row.mode == BODY:
            x, y, yaw = self.part.joints
            turn = _turn(last.positions[yaw])
            rate, (ahead, aside) = float(last.velocities[yaw]), self.file.yaw_axis
            linear = turn.T @ last.velocities[[x, y]] + rate * np.array([aside, -ahead])
            return np.array([*linear, 0.0, 0.0, 0.0, rate])
        own = np.zeros(len(last.velocities))
        own[list(self.part.joints)] = last.velocities[list(self.part.joints)]
        assert self.part.tool is not None
        twist = self.file.kinematics.twist(last.positions, own, self.part.tool, row.frame)
        return twist * (self.period_s if row.mode == DELTA else 1.0)

    def _moved(self, row: Told, last: Measured, now: Measured) -> tuple[FloatArray, FloatArray]:
        """Displacement of tool or base, linear and angular, in the row's unit."""
        unit = 1.0 if row.mode == DELTA else self.period_s
        own = list(self.part.joints)
        if row.mode == BODY:
            x, y, yaw = now.positions[own] - last.positions[own]
            # base_link's origin swings about the axis it turns on; to first order of the turn.
            ahead, aside = self.file.yaw_axis
            swing = yaw * np.array([aside, -ahead])
            linear = _turn(last.positions[own[2]]).T @ np.array([x, y]) + swing
            return np.array([*linear, 0.0]) / unit, np.array([0.0, 0.0, yaw]) / unit
        moved = last.positions.copy()
        moved[own] = now.positions[own]
        assert self.part.tool is not None
        pose = self.file.kinematics.pose
        place, turn = pose(moved, self.part.tool, self.root)
        place_then, turn_then = pose(last.positions, self.part.tool, self.root)
        _, axes = pose(last.positions, row.frame, self.root)
        rotation = np.asarray(pinocchio.log3(turn @ turn_then.T))
        return axes.T @ (place - place_then) / unit, axes.T @ rotation / unit

    def _pose(self, state: Measured, frame: str) -> tuple[FloatArray, FloatArray]:
        assert self.part.tool is not None
        return self.file.kinematics.pose(state.positions, self.part.tool, frame)

    def _worst_joint(self, row: Told, errors: list[tuple[int, float]]) -> Finding:
        block, own = self._block(row), list(self.part.joints)
        limits = {j: float(block["tracking"][own.index(j)]) for j, _ in errors}
        nearness = min((abs(error - limits[j]) for j, error in errors), default=math.inf)
        for j, error in errors:
            if error > limits[j]:
                return Finding(40, self.file.joints[j].name, nearness)
        return Finding(nearness=nearness)

    def _worst_half(self, row: Told, linear: float, angular: float) -> Finding:
        block = self._block(row)
        off = {"linear": linear, "angular": angular}
        nearness = min(abs(off[name] - block[f"{name}_tracking"]) for name in off)
        for name, value in off.items():
            if value > block[f"{name}_tracking"]:
                return Finding(40, name, nearness)
        return Finding(nearness=nearness)

    # --- G041 ---

    def _stuck(self, row: Told, now: Measured) -> Finding:
        if row.mode in TARGETS:
            left = {j: abs(float(row.values[j] - now.positions[j])) for j in row.active}
            stuck = [self.stuck.target_of_joint(j, left[j]) for j in sorted(row.active)]
        elif row.mode == VELOCITY:
            share = self._share(row) * self.period_s
            told_to = {j: share * float(row.values[j]) for j in row.active}
            stuck = [self.stuck.told_to_joint(j, told_to[j]) for j in sorted(row.active)]
        elif row.mode == POSE:
            place, turn = self._pose(now, row.frame)
            distance = float(np.linalg.norm(place - row.values[:3]))
            angle = angle_between(turn, rotation_of(row.values[3:]))
            stuck = [self.stuck.pose_of_part(distance, angle)]
        elif row.mode in HALVES:
            share = self._share(row) * (1.0 if row.mode == DELTA else self.period_s)
            stuck = [self.stuck.told_to_part(share * row.values)]
        else:
            stuck = []
        first = next((j for j in stuck if j is not None), None)
        return Finding() if first is None else Finding(41, self.file.joints[first].name)

    def _share(self, row: Told) -> float:
        """ "`gain.lower`, or the gain's middle where that is 0"."""
        lower, upper = self._block(row)["gain"]
        return float(lower if lower > 0.0 else 0.5 * (lower + upper))

    # --- G042, grasps ---

    def _grasp(self, row: Told | None, last: Measured, now: Measured) -> Finding:
        block = self.part.modes.get(OPENING)
        if block is None:
            return Finding()
        joint = self.file.joints[self.part.joints[0]]
        opening = float(now.positions[self.part.joints[0]])
        if row is not None:
            target = float(row.values[0])
            if row.mode == CLOSED:
                target = joint.lower if target == 1.0 else joint.upper
            if self.target is None or abs(target - self.target) > joint.tolerance:
                self._begin_grasp(target, opening)
        if self.target is None:
            return Finding()
        is_short = abs(opening - self.target) > joint.tolerance
        if self.gripped is not None:
            closes = self.target < self.gripped
            lost = self.gripped - opening if closes else opening - self.gripped
            slip = math.inf if block["slip_limit"] is None else block["slip_limit"]
            if lost > slip:
                return Finding(42, joint.name, abs(lost - slip))
            if not is_short:
                self._begin_grasp(self.target, opening)
            return Finding(nearness=abs(lost - slip))
        velocity = float(now.velocities[self.part.joints[0]])
        way = -1.0 if self.target < opening else 1.0
        gone = way * (opening - self.told_at)
        self.goes = self.goes or way * velocity >= joint.standstill or gone > joint.tolerance
        speed = speed_of(self.file, replace(now, came_from=last.positions), self.part.joints[0])
        stands = self.goes and speed < joint.standstill
        self.still = self.still + 1 if is_short and stands else 0
        if self.still >= STATES_TO_HOLD:
            self.gripped = opening
        return Finding()

    def _begin_grasp(self, target: float, opening: float) -> None:
        """ "What it held it still holds when told to go further the same way"."""
        held, before = self.gripped is not None, self.target
        same_way = before is not None and (before < opening) == (target < opening)
        self.target, self.told_at, self.goes = target, opening, held and same_way
        self.still, self.gripped = 0, None

    def _block(self, row: Told) -> Block:
        return self.part.modes[row.mode]

    def _of(self, j: int, name: str) -> float:
        return self.limits[self.file.joints[j].name][name]


def check_efforts(file: GateFile, limits: dict[str, dict[str, float]], now: Measured) -> Finding:
    """G042: the first commanded joint that presses too hard."""
    for index, joint in enumerate(file.joints):
        if abs(now.efforts[index]) > limits[joint.name]["contact_limit"]:
            return Finding(42, joint.name)
    return Finding()


def distance_to_hull(point: FloatArray, corners: list[FloatArray]) -> float:
    """Distance of a point to the convex hull of a few others: the nearest point is a mixture, with
    weights that are not negative, of some of them; all choices are tried."""
    best = math.inf
    for count in range(1, len(corners) + 1):
        for chosen in combinations(corners, count):
            base, spread = chosen[0], np.array([c - chosen[0] for c in chosen[1:]]).T
            weights = np.zeros(0)
            nearest = base
            if count > 1:
                weights, *_ = np.linalg.lstsq(spread, point - base, rcond=None)
                nearest = base + spread @ weights
            if np.all(weights >= -1e-9) and weights.sum() <= 1.0 + 1e-9:
                best = min(best, float(np.linalg.norm(point - nearest)))
    return best


def _turn(yaw: float) -> FloatArray:
    """Base axes in odom, columns x and y."""
    return np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
