"""A second mind on where rows lead, from its rules, not its code: pinocchio, coal, numpy.

Between rows it looks at many configurations instead of proving anything, so it gives two margins:
at the row and where braking ends, and at all that it looked at. Slow, and made to be read.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from fairlead.messages import FloatArray
from tests.differential.base_motion import base_change, told_velocities, zone_margin
from tests.differential.posed_robot import PosedRobot
from tests.differential.row_ends import Margins, RowEnd, RowMargins, Spread, least

DAMPING = 0.02
HARDLY, LAST_STEP, MOST_STEPS = 1e-4, 2e-3, 12
MOST_BEND, LEAST_BEND = 0.2, 2e-3
REACHED, LONGEST_STEP, POSE_STEPS = 1e-6, 0.5, 50
DOUBTFUL = 1.25
"""Of the singularity limit, for each rad that nobody knows of where a row begins."""
LOOKS = 12
TARGETS = ("joint_position", "cartesian_pose")


class PathReference:
    """One robot's shape and surroundings, by its gate file and its description."""

    def __init__(self, data: dict[str, Any], urdf: Path) -> None:
        self._data = data
        self._robot = PosedRobot(data, urdf)
        self.names = self._robot.names
        self._period = data["period_ns"] * 1e-9
        self._joints = data["joints"]
        self._parts = {part["name"]: part for part in data["parts"]}

    def rows(
        self, positions: FloatArray, part: str, mode: str, values: FloatArray, certified: int
    ) -> Iterator[list[RowMargins]]:
        """Margins of each row, for the middle and either end of the gain; after the certified rows
        for the middle alone. The robot stands still at first."""
        branches = [positions.copy() for _ in range(3)]
        spread, adds_up = Spread(positions.copy(), positions.copy()), mode not in TARGETS
        base_before = 0.0
        low, high = self._parts[part]["modes"][mode].get("gain", [1.0, 1.0])
        gains = [(low + high) / 2.0, low, high]
        for number, row in enumerate(values):
            if number == certified:
                branches, gains = branches[:1], gains[:1]
                spread = Spread(branches[0], branches[0])
            ends = [
                self._after(now, part, mode, row, gain)
                for now, gain in zip(branches, gains, strict=True)
            ]
            doubt = float((spread.highest - spread.lowest)[self._robot.own(part)].max())
            spread = spread.after(branches, [after.joints for after in ends], adds_up)
            base_now = max(map(self._base_share, branches, ends))
            drift = max(base_now, base_before)  # of certified rows the fastest so far counts
            base_before = drift if number + 1 < certified else base_now
            found = []
            for now, after in zip(branches, ends, strict=True):
                speed = (after.joints - now) / self._period
                margins = self._margins(now, after.joints, speed, (part, mode), spread)
                if mode.startswith("cartesian"):
                    left = self._slow_enough(part, now, after)
                    margins.at_ends[26] = margins.anywhere[26] = left
                    bent = self._straight_enough(part, now, after)
                    margins.at_ends[30] = margins.anywhere[30] = bent
                    self._doubt_singularity(margins, now, part, doubt)
                self._carry(margins, now, part, drift)
                found.append(margins)
            branches = [after.joints for after in ends]
            yield found

    def reached(
        self,
        positions: FloatArray,
        part: str,
        mode: str,
        values: FloatArray,
        gains: Sequence[float],
        switched_up: bool = False,
    ) -> list[FloatArray]:
        """Where the rows lead, and where braking from there ends, if of each row that gain happens;
        with the switch up what is left of a row is a part of the next. The robot stands still at
        first."""
        left = np.zeros_like(values[0])
        for row, gain in zip(values, gains, strict=True):
            asked = row + left
            if switched_up:  # the turns one after the other
                asked[3:] = pinocchio.log3(pinocchio.exp3(row[3:]) @ pinocchio.exp3(left[3:]))
            before, positions = positions, self._after(positions, part, mode, asked, gain).joints
            left = (1.0 - gain) * asked * switched_up
        return [
            positions,
            self._stopping(positions, (positions - before) / self._period, 1.0, True),
        ]

    def margin(self, positions: FloatArray, part: str, mode: str) -> float:
        """What is left to the base's zones, or else to volumes."""
        return self._at(positions, part, mode)[34 if part == "base" else 31]

    def start_margin(self, positions: FloatArray, part: str, mode: str) -> float:
        """The smallest margin where the robot stands."""
        found = self._at(positions, part, mode)
        if part == "base":
            self._robot.place(positions)
            found |= {31: self._robot.volume_margin(part), 32: self._robot.capsule_margin()}
        return min(found.values())

    def jacobian(self, positions: FloatArray, part: str) -> FloatArray:
        """Of a part's tool, along its root's axes, by its own joints: 6 rows."""
        return self._robot.jacobian(positions, part)

    def tool(self, positions: FloatArray, part: str) -> Any:
        """Where a part's tool is, an SE3."""
        self._robot.place(positions)
        return self._robot.frame(self._parts[part]["tool_frame"]).copy()

    def _after(self, now: FloatArray, part: str, mode: str, row: FloatArray, gain: float) -> RowEnd:
        after, own = now.copy(), self._robot.own(part)
        if mode == "joint_position":
            after[own] = row[own]
        elif mode == "joint_velocity":
            after[own] += (
                gain * self._period * told_velocities(self._data["base"], self.names, now, row)[own]
            )
        elif mode == "body_twist":
            yaw = now[own[2]]
            after[own] += base_change(self._data["base"], yaw, gain * self._period * row)
        else:
            goal, is_pose = self._goal(now, part, mode, row, gain), mode == "cartesian_pose"
            return RowEnd(after, self._reach(after, part, goal, is_pose))
        return RowEnd(after, after)

    def _reach(self, after: FloatArray, part: str, goal: Any, is_pose: bool) -> FloatArray:
        """Least squares, until a step that is hardly damped moves no joint much, or the tool is at
        the pose it has to be at. Says where one whole step leads."""
        own, tool, straight = self._robot.own(part), self._parts[part]["tool_frame"], after.copy()
        for index in range(POSE_STEPS if is_pose else MOST_STEPS):
            self._robot.place(after)
            here = self._robot.frame(tool)
            turned = pinocchio.log3(goal.rotation @ here.rotation.T)
            shift = goal.translation - here.translation
            if is_pose and max(np.linalg.norm(shift), np.linalg.norm(turned)) <= REACHED:
                break
            jacobian = self._robot.jacobian(after, part)
            missing = np.concatenate([shift, turned])
            step, rest = (damped(jacobian, missing, by) for by in (DAMPING, HARDLY))
            if index == 0:
                straight[own] += rest
            largest = float(np.abs(step).max())
            if not is_pose and max(largest, float(np.abs(rest).max())) <= LAST_STEP:
                after[own] += rest
                break
            after[own] += step * (min(1.0, LONGEST_STEP / largest) if is_pose else 1.0)
        return straight

    def _base_share(self, now: FloatArray, after: RowEnd) -> float:
        """The fastest joint of the base, in its velocity limits."""
        if self._data["base"] is None:
            return 0.0
        moved = (after.joints - now) / self._period
        own = [self.names.index(name) for name in self._data["base"]["joints"]]
        speeds = {i: min(abs(float(moved[i])), self._limit(i)) for i in own}
        return max(v / float(self._joints[i]["velocity_limit"]) for i, v in speeds.items())

    def _carry(self, margins: RowMargins, now: FloatArray, part: str, share: float) -> None:
        """A base that moves: what it carries drifts, and stays where it is else."""
        if part != "base" or share == 0.0:
            return
        self._robot.place(now)
        base = self._data["base"]
        for code, margin in (
            (31, self._robot.volume_margin(part)),
            (32, self._robot.capsule_margin()),
        ):
            drift = base["tool_drift" if code == 31 else "clearance_drift"]
            margins.at_ends[code] = margins.anywhere[code] = margin - share * drift

    def _slow_enough(self, part: str, now: FloatArray, after: RowEnd) -> float:
        """What is left to the slowest joint's velocity limit [rad/s], of the straight way too."""
        limits = {
            joint: float(self._joints[joint]["velocity_limit"]) for joint in self._robot.own(part)
        }
        fastest = np.maximum(np.abs(after.joints - now), np.abs(after.straight - now))
        return float(min(limit - fastest[i] / self._period for i, limit in limits.items()))

    def _straight_enough(self, part: str, now: FloatArray, after: RowEnd) -> float:
        """What is left to the most that a joint's way may bend; all turn, or all slide [rad]."""
        own = self._robot.own(part)
        longest = float(np.abs(after.straight - now)[own].max())
        return MOST_BEND * longest + LEAST_BEND - float(np.abs(after.joints - after.straight).max())

    def _goal(self, now: FloatArray, part: str, mode: str, row: FloatArray, gain: float) -> Any:
        """Where a row wants the tool."""
        if mode == "cartesian_pose":
            return pinocchio.XYZQUATToSE3(row)
        motion = gain * (self._period if mode == "cartesian_twist" else 1.0) * row
        start = self.tool(now, part)
        turn = pinocchio.exp3(motion[3:]) @ start.rotation
        return pinocchio.SE3(turn, start.translation + motion[:3])

    def _stopping(
        self, after: FloatArray, speed: FloatArray, share: float, lags: bool
    ) -> FloatArray:
        """Where braking has got to after that share of its time."""
        moving = [i for i in range(len(self._joints)) if speed[i] != 0.0]
        base = self._data["base"]
        waits = {
            i: (base["reaction_s"] if base and self.names[i] in base["joints"] else 0.0)
            + (self._joints[i]["stop_lag"] if lags else 0.0)
            for i in moving
        }
        slowing = {i: self._joints[i]["acceleration_limit"] for i in moving}
        speeds = {i: float(np.clip(speed[i], -self._limit(i), self._limit(i))) for i in moving}
        ends = [waits[i] + abs(speeds[i]) / slowing[i] for i in moving]
        time, found = share * max(ends, default=0.0), after.copy()
        for i in moving:
            braking = float(np.clip(time - waits[i], 0.0, abs(speeds[i]) / slowing[i]))
            mean = speeds[i] - 0.5 * slowing[i] * braking * np.sign(speeds[i])
            found[i] += speeds[i] * min(time, waits[i]) + mean * braking
        return found

    def _limit(self, joint: int) -> float:
        """The fastest a joint can be told to go; one slide of a turned base gets what both got."""
        base, own = self._data["base"], float(self._joints[joint]["velocity_limit"])
        if base is None or base["command_frame"] != "against_yaw":
            return own
        slides = [self.names.index(name) for name in base["joints"][:2]]
        limits = [float(self._joints[slide]["velocity_limit"]) for slide in slides]
        return math.hypot(*limits) if joint in slides else own

    def _margins(
        self, now: FloatArray, after: FloatArray, speed: FloatArray, told: tuple[str, str],
        spread: Spread
    ) -> RowMargins:  # fmt: skip
        part, mode = told
        lags = mode not in TARGETS
        end = self._stopping(after, speed, 1.0, lags)
        ends = least([self._at(after, part, mode), self._at(end, part, mode)])
        furthest = np.where(speed > 0.0, spread.highest, spread.lowest) + end - after
        ends[24] = min(self._towards(i, furthest, speed) for i in self._robot.own(part))
        shares = np.linspace(0.0, 1.0, LOOKS)
        way = [now + share * (after - now) for share in shares]
        way += [self._stopping(after, speed, share, lags) for share in shares]
        looks = [self._at(place, part, mode) for place in way]
        return RowMargins(ends, least([ends, *looks]))

    def _towards(self, joint: int, end: FloatArray, speed: FloatArray) -> float:
        bounds = self._joints[joint].get("bounds")
        if bounds is None or speed[joint] == 0.0:
            return math.inf
        if speed[joint] > 0.0:
            return float(bounds["upper"] - end[joint])
        return float(end[joint] - bounds["lower"])

    def _doubt_singularity(
        self, margins: RowMargins, now: FloatArray, part: str, doubt: float
    ) -> None:
        """A limit that is higher; what is broken before the row may stay as it is."""
        more = DOUBTFUL * doubt * float(self._parts[part]["singularity_limit"])
        was = min(0.0, self._singularity_margin(now, part) - more)
        for found in (margins.at_ends, margins.anywhere):
            found[33] -= more + was

    def _singularity_margin(self, positions: FloatArray, part: str) -> float:
        values = np.linalg.svd(self._robot.jacobian(positions, part), compute_uv=False)
        return float(values.min()) - float(self._parts[part]["singularity_limit"])

    def _at(self, positions: FloatArray, part: str, mode: str) -> Margins:
        if part == "base":
            return {34: self._zone_margin(positions)}
        self._robot.place(positions)
        found = {31: self._robot.volume_margin(part), 32: self._robot.capsule_margin()}
        if mode.startswith("cartesian"):
            found[33] = self._singularity_margin(positions, part)
        return found

    def _zone_margin(self, positions: FloatArray) -> float:
        return zone_margin(self._data["base"], positions[self._robot.own("base")])


def damped(jacobian: FloatArray, motion: FloatArray, by: float) -> FloatArray:
    """The step of least squares to a motion. Shapes ``[6, n]``, ``[6]`` -> ``[n]``."""
    square = jacobian @ jacobian.T + by**2 * np.eye(6)
    return np.asarray(jacobian.T @ np.linalg.solve(square, motion))
