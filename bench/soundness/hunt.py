"""Attacks that know the rules: always towards where the least room is left."""

from __future__ import annotations

import numpy as np

from bench.equipment.kinematics import Kinematics
from bench.soundness.arena import Arena
from bench.soundness.attack import ROWS_MOST, Parts, everything, some_mode
from bench.soundness.chunk_rows import Row
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment

HUNTED = ("bounds", "workspace", "self-collision")
STEP = 1e-3
NOTHING_M = 1e-9
LEAST_SCALE = 0.02
"""Below this share of full scale a refused hunter goes aside for a chunk and begins anew."""


class Hunter:
    """Every arm goes down the slope of one rule's room: gently where it was refused, then again.

    What carries the arms is driven at random beside it; the composite switch flickers in some
    episodes. With a claim for each arm they go for each other, by rows of 1 or 2: both of them, or
    one for another that wanders in directions that last.
    """

    def __init__(
        self,
        robot: RobotManifest,
        rng: np.random.Generator,
        arena: Arena,
        rule: str | None = None,
        claims: dict[str, tuple[str, ...]] | None = None,
        rows_most: int | None = None,
    ) -> None:
        self.ticks, self.claims = 250, claims or everything(robot)
        self._robot, self._rng, self._arena = robot, rng, arena
        self._rule = rule or HUNTED[int(rng.integers(len(HUNTED)))]
        self._rows_most = rows_most or int(rng.integers(1, ROWS_MOST + 1))
        self._kinematics = Kinematics(robot.description_path(), robot.measured_joint_names)
        self._modes: dict[str, dict[str, ControlMode]] = {}
        self._parts: dict[str, Parts] = {}
        for source, parts in self.claims.items():
            told = [p for p in parts if len(robot.part(p).joints) >= 6 or rng.random() < 0.5]
            self._modes[source] = {part: some_mode(robot, part, rng) for part in told}
            self._parts[source] = Parts(robot, self._modes[source])
        self._scale = dict.fromkeys(self.claims, 1.0)
        self._aside = dict.fromkeys(self.claims, False)
        self._quarry = ""
        if len(self.claims) > 1 and rng.random() < 0.6:
            self._quarry = str(rng.choice(list(self.claims)))
        self._way: dict[str, FloatArray] = {}

    def chunk(self, source: str, now: Moment, tick: int) -> list[Row]:
        """As `Attack.chunk`."""
        own = self._parts[source]
        wishes = {}
        for part in self._modes[source]:
            wish = self._rng.uniform(-1.0, 1.0, own.axes(part))
            if source == self._quarry:
                wish = self._scale[source] * self._way.setdefault(part, wish)
            elif part in own.arms and not self._aside[source]:
                wish = self._scale[source] * self._down(source, part, now)
            wishes[part] = wish
        return [own.row(wishes, now) for _ in range(int(self._rng.integers(self._rows_most)) + 1)]

    def answered(self, source: str, row: Row | None) -> None:
        """As `Attack.answered`."""
        if source == self._quarry and (row is None or self._rng.random() < 0.1):
            self._way.clear()
        scale = self._scale[source] * (0.5 if row is None else 1.5)
        self._aside[source] = scale < LEAST_SCALE
        self._scale[source] = 1.0 if self._aside[source] else min(1.0, scale)
        self._parts[source].go_on_after(row)

    def _down(self, source: str, part: str, now: Moment) -> FloatArray:
        """The wish that takes room away fastest, its largest axis at full scale."""
        joints = [self._robot.joint_names.index(name) for name in self._robot.part(part).joints]
        around = np.tile(now.positions, (len(joints) + 1, 1))
        for row, joint in enumerate(joints, start=1):
            around[row, joint] += STEP
        room = self._room(source, around, joints)
        way = -(room[1:] - room[0])
        mode = self._modes[source][part]
        if mode.is_tool_mode:
            effector = self._robot.part(part).end_effector
            assert effector is not None
            velocities = np.zeros(len(now.positions))
            velocities[joints] = way
            tool = self._robot.end_effector(effector).tool_frame
            base = self._robot.base_frame
            way = self._kinematics.twist(now.positions, velocities, tool, base)
        return np.asarray(way / max(float(np.abs(way).max()), 1e-12))

    def _room(self, source: str, around: FloatArray, joints: list[int]) -> FloatArray:
        """The room ``[B]`` of the rule, as far as these joints have a say in it."""
        if self._rule == "bounds":
            own = around[:, joints]
            lower, upper = self._arena.lower[joints], self._arena.upper[joints]
            return np.asarray(np.minimum(own - lower, upper - own).min(axis=1))
        if self._rule == "workspace":
            return self._arena.room(around)["workspace"]
        pairs = self._arena.room_of_pairs(around)
        moved = np.ptp(pairs, axis=1) > NOTHING_M
        others = [name for name in self.claims if name != source]
        if others:
            moved &= self._moved_by(others, around[0], pairs[:, 0])
        return np.asarray(pairs[moved][int(np.argmin(pairs[moved, 0]))])

    def _moved_by(self, others: list[str], q: FloatArray, rooms: FloatArray) -> FloatArray:
        """Which pairs have a link of another claim's arm: those that its first joint moves."""
        turned = []
        for part in (part for other in others for part in self._parts[other].arms):
            first = self._robot.joint_names.index(self._robot.part(part).joints[0])
            turned.append(q + STEP * (np.arange(len(q)) == first))
        changed = self._arena.room_of_pairs(np.stack(turned)) - rooms[:, None]
        return np.asarray(np.abs(changed).max(axis=1) > NOTHING_M)
