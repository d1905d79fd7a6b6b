"""Adversarial chunks against the real core, and what becomes of the robot by numbers of our own.

Tick by tick: the robot makes of each row another share of what it was told, tells the gate where it
is, and goes on as long as the gate grants it. Wherever it is, it may be told to hold. Half of
the chunks are judged in realtime, where the gate misses two states of five; there the robot brakes
when the rows run out, and further chunks come meanwhile. Of some robots every velocity is measured
as 0. An arm that takes joint targets also sags, under a policy that tells it to be where it is.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from bench.equipment.case import Pacing
from bench.equipment.kinematics import Kinematics
from bench.soundness.adversary import KINDS, ROWS_MOST, Adversary
from bench.soundness.arena import SPEED, SPEED_TOLERANCE, Arena
from bench.soundness.chunk_rows import Row
from bench.soundness.followed import Soundness
from bench.soundness.gate_loop import GateLoop
from bench.soundness.prediction import DAMPINGS, NotReachedError
from bench.soundness.share_robot import Faults, ShareRobot
from bench.soundness.side_by_side import TICKS, SideBySide
from bench.soundness.starts import Starts
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray, Outcome, Verdict
from fairlead.modes import ControlMode
from fairlead.paths import gate_config
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment, Tick

PACE = 500
CHUNKS = {"lockstep": 1, "realtime": 8, "sagging": 12}
"""Of a run, one behind the other."""
SHORT = 3
"""Rows of those that come in a held tick, at most."""
OTHERS = 0.1
"""Of them, how many tell other parts than the one before."""
STUCK = 0.25
SAG = 2e-3
"""The most that a joint sags [rad]."""
PACINGS: tuple[Pacing, Pacing] = ("lockstep", "realtime")
MISSED = 0.4
TOLD_MOTIONS = (
    *(ControlMode.CARTESIAN_DELTA, ControlMode.CARTESIAN_TWIST),
    *(ControlMode.CARTESIAN_POSE, ControlMode.JOINT_VELOCITY),
)
NUMERIC = 1e-6
"""Rooms this little below 0 are rounding [rad or m]."""


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
        self._shares.begin(around[0], np.ones((1, len(robot.parts))))
        self._loop = GateLoop(self._shares, config)
        self._adversary = Adversary(robot, recorded, self._rng)
        self._starts = Starts(robot, self.arena, around, self._rng)
        self._kinematics = Kinematics(robot.description_path(), robot.measured_joint_names)
        self._beside = SideBySide(self._loop, recorded, self._moment, self._rng)
        self.found = Soundness()
        self._waiting: list[tuple[str, FloatArray, FloatArray, float]] = []
        self._period_s = robot.tick_period_ns * 1e-9
        limits = [joint.get("velocity_limit") for joint in file["joints"]]
        self._fastest = np.array([np.inf if one is None else one for one in limits])
        self._fastest[self._shares.base] = np.inf  # two rows' slides, turned, add up in one
        self._targets = [
            part.name for part in robot.parts if ControlMode.JOINT_POSITION in part.control_modes
        ]
        base = file["base"] or {"tool_drift": 0.0, "clearance_drift": 0.0}
        self._drifts = {"workspace": base["tool_drift"], "self-collision": base["clearance_drift"]}

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
        kinds = [*KINDS, "recorded"]
        kinds += ["sagging"] if self._targets else []
        kinds += ["side by side"] if len(self._beside.claims) > 1 else []
        kind = kinds[self.found.chunks % len(kinds)]
        pacing = PACINGS[self.found.chunks // len(kinds) % 2]
        self._shares.prediction.damping = float(self._rng.choice(DAMPINGS))
        if kind == "recorded":
            start, rows = self._adversary.spoiled()
            self._follow(kind, pacing, self._around[start], rows)
        elif kind == "sagging":
            self._sag("lockstep", 0.0, self._starts.pick(near=True))
        elif kind == "side by side":
            self._side_by_side(pacing, self._starts.pick_folded())
        else:
            q = self._starts.pick(near=bool(self._rng.random() < 0.5))
            self._adversary.begin(kind)
            self._follow(kind, pacing, q, self._adversary.chunk(self._moment(q)))

    def _note(self, verdict: Verdict) -> None:
        if verdict.outcome == Outcome.RELEASED:
            self.found.released += 1
        elif verdict.outcome == Outcome.TRUNCATED:
            self.found.truncated[verdict.code] += 1
        else:
            self.found.refused[verdict.code] += 1

    def _follow(self, kind: str, pacing: Pacing, q: FloatArray, rows: Sequence[Row]) -> None:
        """At both ends of the gain, its middle, and shares drawn for each part.

        Drawn is one of the ends: for the whole run, for each tick; and any for each tick.
        """
        ticks, parts = CHUNKS[pacing] * (ROWS_MOST + 1), len(self._robot.parts)
        mixed = np.tile(self._rng.integers(0, 2, parts).astype(float), (ticks, 1))
        shares = [np.full((ticks, parts), share) for share in (0.0, 1.0, 0.5)]
        corners = self._rng.integers(0, 2, (ticks, parts)).astype(float)
        shares += [mixed, corners, self._rng.random((ticks, parts))]
        if not self._shares.prediction.depends_on_shares(rows[0]):
            shares = shares[: 1 if pacing == "lockstep" else 2]
        self.found.chunks += 1
        self.found.by_kind[kind] += 1
        for number, share in enumerate(shares):
            faults = Faults(is_stuck=bool(self._rng.random() < STUCK))
            what = f"{kind} chunk {self.found.chunks} in {pacing}{', stuck' * faults.is_stuck}"
            self._shares.begin(q, share, faults)
            self._loop.begin(0, pacing=pacing)
            if not self._chunk(what, pacing, rows, number == 0):
                return
            for more in range(1, CHUNKS[pacing]):
                if kind == "recorded" or self._rng.random() < OTHERS:
                    self._adversary.begin(str(self._rng.choice(KINDS)))
                self._adversary.go_on_after(None)
                next_rows = self._adversary.chunk(self._moment(self._loop.now.positions))
                next_rows = next_rows[: int(self._rng.integers(1, SHORT + 1))]
                self._chunk(f"{what}, then chunk {more}", pacing, next_rows)

    def _side_by_side(self, pacing: Pacing, q: FloatArray) -> None:
        """Every claim by itself, with one share of the three for all ticks and parts, or any."""
        ends = self._rng.choice([0.0, 0.5, 1.0], size=len(self._robot.parts))
        any_share = self._rng.random((TICKS, len(self._robot.parts)))
        share = np.tile(ends, (TICKS, 1)) if self._rng.random() < 0.8 else any_share
        self.found.chunks += 1
        self.found.by_kind["side by side"] += 1
        what = f"side by side {self.found.chunks} in {pacing}"
        self._shares.begin(q, share, Faults(is_stuck=bool(self._rng.random() < STUCK)))
        verdicts: list[Verdict] = []
        try:
            for number, done in enumerate(self._beside.ticks(pacing, verdicts.append)):
                self._see(f"{what}, tick {number}", done)
                self.found.rows += bool(done.commands)
                self.found.in_realtime += bool(done.commands) and pacing == "realtime"
        except NotReachedError:
            self.found.not_reached += 1
        if verdicts:
            self._note(verdicts[0])
        self.found.cut.update(one.code for one in self._loop.take_cut() if one.code)

    def _sag(self, pacing: Pacing, back: float, q: FloatArray) -> None:
        """Told each time to be where it is measured, or ``back`` by a share of what it sags."""
        self.found.chunks += 1
        self.found.by_kind["sagging"] += 1
        sag = SAG * self._rng.uniform(-1.0, 1.0, self._robot.n_dof)
        chunks = CHUNKS["sagging"]
        self._shares.begin(q, np.ones((2 * chunks, len(self._robot.parts))), Faults(sag))
        self._loop.begin(0, pacing=pacing)
        what = f"sagging chunk {self.found.chunks} in {pacing}, back by {back:g}"
        for number in range(chunks):
            values = self._loop.now.positions[: self._robot.n_dof] - (number > 0) * back * sag
            row = {}
            for part in self._targets:
                own = tuple(self._robot.joint_names.index(n) for n in self._robot.part(part).joints)
                wide = np.zeros(self._robot.n_dof)
                wide[list(own)] = values[list(own)]
                row[part] = PartCommand(ControlMode.JOINT_POSITION, "", wide, own)
            self._chunk(f"{what}, chunk {number}", pacing, [row], number == 0)

    def _chunk(
        self, what: str, pacing: Pacing, rows: Sequence[Row], is_first: bool = False
    ) -> bool:
        """Propose it and follow it as far as the gate lets it go; whether it was released."""
        verdict = self._loop.propose(rows)
        if is_first:
            self._note(verdict)
        is_released = verdict.outcome != Outcome.REFUSED
        missed = MISSED if pacing == "realtime" else 0.0
        ticks = verdict.released_last - verdict.released_first + 1 if is_released else 0
        for tick in range(-(pacing == "realtime"), ticks):  # the present one has begun without it
            try:
                done = self._loop.advance(what, is_heard=bool(self._rng.random() >= missed))
            except NotReachedError:
                self.found.not_reached += 1
                return False
            if done is None:
                return False
            self._see(f"{what}, row {tick}", done)
            if tick >= 0 and not done.commands:
                # Without a code: rows that a lost state had held up were released again.
                self.found.cut.update(one.code for one in self._loop.take_cut() if one.code)
                return is_released
            self.found.rows += tick >= 0
            self.found.in_realtime += tick >= 0 and pacing == "realtime"
            self.found.after_hold += tick >= 0 and not is_first
        return is_released

    def _see(self, what: str, done: Tick) -> None:
        """Where a tick led, and where a hold would."""
        modes = {part: command.mode.yaml_name for part, command in done.commands.items()}
        told = f"{what}, share {self._shares.share.round(2)}, {modes}"
        self._see_speeds(told, done)
        drives = self._shares.base_speed()
        stops = self._rng.integers(0, 2, self._robot.n_dof).astype(float)
        for way, place in (
            ("", done.after.positions),
            (", then held", self._shares.stopped(done)),
            (f", then held, of each joint {stops}", self._shares.stopped(done, stops)),
        ):
            self._waiting.append((told + way, place, self._shares.told, drives))

    def _see_speeds(self, told: str, done: Tick) -> None:
        """Of the joints of arms that are told motions: a target is at once where it shall be."""
        moved = (done.after.positions - done.before.positions)[: self._robot.n_dof]
        room = (1.0 + SPEED_TOLERANCE) * self._fastest - np.abs(moved) / self._period_s
        for part, command in done.commands.items():
            if command.mode not in TOLD_MOTIONS:
                continue
            own = [self._robot.joint_names.index(name) for name in self._robot.part(part).joints]
            self.found.see(SPEED, float(room[own].min()), told)

    def _look(self) -> None:
        """Ask the arena about everything followed since the last time.

        What a base carries may be off by its drift. What sags may be as far beyond a limit as it
        sags, twice: told to be where it is once.
        """
        if not self._waiting:
            return
        whats, places, told, drives = zip(*self._waiting, strict=True)
        rooms = self.arena.room(np.stack(places))
        self.found.configurations += len(places)
        self.found.near += int(np.sum(rooms["self-collision"] < self.arena.clearance - NUMERIC))
        sags = np.array(["sagging" in what for what in whats])
        meant = self.arena.room(np.stack(told)) if sags.any() else rooms
        for rule, free in rooms.items():
            if np.isposinf(free).all():
                continue  # nothing of the kind on this robot
            drifted = free - self._drifts.get(rule, 0.0) * np.array(drives)
            room = np.where(sags, drifted + 2.0 * np.maximum(meant[rule] - free, 0.0), drifted)
            self.found.worst[rule] = min(self.found.worst[rule], float(room.min()))
            for index in np.flatnonzero(~(room >= -NUMERIC)):
                self.found.see(rule, float(room[index]), whats[index])
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
