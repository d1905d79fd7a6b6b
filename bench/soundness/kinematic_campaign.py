"""Adversarial chunks against the real core, and what becomes of the robot by numbers of our own.

Tick by tick: the robot makes of each row another share of what it was told, tells the gate where it
is, and goes on as long as the gate grants it. Wherever it is, it may be told to hold. Half of
the chunks are judged in realtime, where the gate misses two states of five.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bench.equipment.case import Pacing
from bench.equipment.kinematics import Kinematics
from bench.soundness.adversary import KINDS, Adversary
from bench.soundness.arena import RULES, Arena
from bench.soundness.chunk_rows import Row
from bench.soundness.gate_loop import GateLoop
from bench.soundness.prediction import NotReachedError
from bench.soundness.share_robot import ShareRobot
from bench.soundness.starts import Starts
from fairlead.messages import FloatArray, Outcome, Verdict
from fairlead.paths import gate_config
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment

PACE = 500
PACINGS: tuple[Pacing, Pacing] = ("lockstep", "realtime")
MISSED = 0.4
NUMERIC = 1e-6
"""Rooms this little below 0 are rounding [rad or m]."""


@dataclass
class Soundness:
    """rows: that acted, of each chunk under several shares; in_realtime: of them, those judged so.

    cut: of these runs, those that the gate ended before the last released row. breaches: by rule,
    places where it was broken, or would have been by a hold. worst: least room left, by rule. near:
    places within the clearance that the gate keeps. told: one line for each of the first breaches.
    """

    chunks: int = 0
    by_kind: Counter[str] = field(default_factory=Counter)
    released: int = 0
    truncated: Counter[int] = field(default_factory=Counter)
    refused: Counter[int] = field(default_factory=Counter)
    rows: int = 0
    in_realtime: int = 0
    cut: Counter[int] = field(default_factory=Counter)
    configurations: int = 0
    not_reached: int = 0
    near: int = 0
    breaches: Counter[str] = field(default_factory=Counter)
    worst: dict[str, float] = field(default_factory=lambda: dict.fromkeys(RULES, np.inf))
    told: list[str] = field(default_factory=list)


class KinematicCampaign:
    """One robot.

    Args:
        recorded: rows of demonstrations. around: configuration ``[rows, measured]`` before each.
        config: the gate's file; None: the robot's own, which is what the rows are held against.
    """

    def __init__(
        self,
        robot: RobotManifest,
        recorded: Sequence[Row],
        around: FloatArray,
        config: Path | None = None,
        seed: int = 1,
    ) -> None:
        self._robot, self._rng, self._around = robot, np.random.default_rng(seed), around
        rules = gate_config(robot.id, "sim")
        file = json.loads(rules.read_text(encoding="utf-8"))
        self.arena = Arena(file)
        self._shares = ShareRobot(robot, file)
        self._shares.begin(around[0], np.zeros((0, len(robot.parts))))
        self._loop = GateLoop(self._shares, config)
        self._adversary = Adversary(robot, recorded, self._rng)
        self._starts = Starts(robot, self.arena, around, self._rng)
        self._kinematics = Kinematics(robot.description_path(), robot.measured_joint_names)
        self.found = Soundness()
        self._waiting: list[tuple[str, FloatArray]] = []

    def run(self, chunks: int, on_progress: Callable[[str], None]) -> Soundness:
        """Judge so many chunks and follow what they release."""
        while self.found.chunks < chunks:
            self._one_case()
            if self.found.chunks % PACE == 0:
                self._look()
                on_progress(
                    f"{self._robot.id}: {self.found.chunks} of {chunks} chunks judged, "
                    f"{self.found.rows} rows followed, breaches {dict(self.found.breaches)}"
                )
        self._look()
        self._loop.close()
        return self.found

    def _one_case(self) -> None:
        kinds = (*KINDS, "recorded")
        kind = kinds[self.found.chunks % len(kinds)]
        if kind == "recorded":
            start, rows = self._adversary.spoiled()
            q = self._around[start]
        else:
            q = self._starts.pick(near=bool(self._rng.random() < 0.5))
            self._adversary.begin(kind)
            rows = self._adversary.chunk(self._moment(q))
        self._follow(kind, q, rows)

    def _note(self, verdict: Verdict) -> None:
        if verdict.outcome == Outcome.RELEASED:
            self.found.released += 1
        elif verdict.outcome == Outcome.TRUNCATED:
            self.found.truncated[verdict.code] += 1
        else:
            self.found.refused[verdict.code] += 1

    def _follow(self, kind: str, q: FloatArray, rows: Sequence[Row]) -> None:
        """At both ends of the gain, its middle, and shares drawn for each row and part.

        Drawn is one of the ends for the whole chunk, and any.
        """
        pacing = PACINGS[self.found.chunks // (len(KINDS) + 1) % 2]
        self.found.chunks += 1
        self.found.by_kind[kind] += 1
        count, parts = len(rows), len(self._robot.parts)
        mixed = np.tile(self._rng.integers(0, 2, parts).astype(float), (count, 1))
        shares = [np.full((count, parts), share) for share in (0.0, 1.0, 0.5)]
        shares += [mixed, self._rng.random((count, parts))]
        if not self._shares.prediction.depends_on_shares(rows[0]):
            shares = shares[:1]
        for number, share in enumerate(shares):
            self._shares.begin(q, share)
            self._loop.begin(0, pacing=pacing)
            verdict = self._loop.propose(rows)
            if number == 0:
                self._note(verdict)
            if verdict.outcome == Outcome.REFUSED:
                return
            what = f"{kind} chunk {self.found.chunks} in {pacing}"
            if pacing == "realtime":
                self._loop.advance(what)  # this tick has begun without it
            self._run(what, verdict, share, MISSED if pacing == "realtime" else 0.0)

    def _run(self, what: str, verdict: Verdict, share: FloatArray, missed: float) -> None:
        """As far as the gate lets it go; ``share`` is what happens of each row and part."""
        released = verdict.released_last - verdict.released_first + 1
        for row in range(released):
            is_heard = bool(self._rng.random() >= missed)
            try:
                done = self._loop.advance(what, is_heard=is_heard)
            except NotReachedError:
                self.found.not_reached += 1
                return
            if done is None or not done.commands:
                # Without a code: rows that a lost state had held up were released again.
                self.found.cut.update(one.code for one in self._loop.take_cut() if one.code)
                return
            self.found.rows += 1
            self.found.in_realtime += missed > 0.0
            modes = {part: command.mode.yaml_name for part, command in done.commands.items()}
            told = f"{what}, row {row}, share {share[row].round(2)}, {modes}"
            self._waiting.append((told, done.after.positions))
            self._waiting.append((f"{told}, then held", self._shares.stopped(done)))

    def _look(self) -> None:
        """Ask the arena about everything followed since the last time."""
        if not self._waiting:
            return
        rooms = self.arena.room(np.stack([place for _, place in self._waiting]))
        self.found.configurations += len(self._waiting)
        self.found.near += int(np.sum(rooms["self-collision"] < self.arena.clearance - NUMERIC))
        for rule, room in rooms.items():
            self.found.worst[rule] = min(self.found.worst[rule], float(room.min()))
            for index in np.flatnonzero(room < -NUMERIC):
                self.found.breaches[rule] += 1
                self.found.told.append(f"{rule} {room[index]:.5f}: {self._waiting[index][0]}")
        self._waiting = []

    def _moment(self, q: FloatArray) -> Moment:
        tools = {
            part.name: self._kinematics.pose(
                q, self._robot.end_effector(part.end_effector).tool_frame, self._robot.base_frame
            )
            for part in self._robot.parts
            if part.end_effector is not None and len(part.joints) > 1
        }
        none = np.zeros(len(q))
        return Moment(q, none, none, tools, np.zeros(3))
