"""Adversarial chunks through the real core into a real simulator, tick by tick."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from bench.soundness.arena import RULES, SPEED, SPEED_TOLERANCE, Arena
from bench.soundness.attack import ARM_JOINTS, Attack
from bench.soundness.attacks import attacks_on, make_attack
from bench.soundness.gate_loop import GateLoop
from bench.soundness.stops import kind_of, story_of
from fairlead.messages import FloatArray, Outcome
from fairlead_tools.measure.driven_robot import DrivenRobot, Tick

EPISODES_MOST = 10_000
REST_TICKS = 40
"""Held after a stop and at an episode's end, so that where motion ends is seen too."""


@dataclass
class Simulated:
    """What came of it.

    rows: executed in ticks, of one chunk each. cut: released rows that were cut off before they
    acted. stops: by code and joint. breaches: ticks by
    rule. told: the first of both.
    idle: those of the breaches in which no arm was told anything. by_attack: rows. broken: episodes
    by attack and rule. worst: least room measured, by rule; of bounds beyond their tolerance.
    """

    episodes: int = 0
    chunks: int = 0
    rows: int = 0
    held: int = 0
    refused: Counter[int] = field(default_factory=Counter)
    truncated: Counter[int] = field(default_factory=Counter)
    cut: Counter[int] = field(default_factory=Counter)
    stops: Counter[str] = field(default_factory=Counter)
    breaches: Counter[str] = field(default_factory=Counter)
    idle: Counter[str] = field(default_factory=Counter)
    by_attack: Counter[str] = field(default_factory=Counter)
    broken: Counter[str] = field(default_factory=Counter)
    worst: dict[str, float] = field(default_factory=lambda: dict.fromkeys((*RULES, SPEED), np.inf))
    told: list[str] = field(default_factory=list)


class SimulatedCampaign:
    """One robot. Each seed has episodes of its own."""

    def __init__(self, loop: GateLoop[DrivenRobot], seed: int = 0) -> None:
        self._loop, self._robot = loop, loop.driven.robot
        self._seed = seed
        self._arena = Arena(loop.file, self._robot.profile("sim").workspace.margin_m)
        measured = self._robot.profile("sim").measured
        tolerances = [measured[name].tolerance for name in self._robot.joint_names]
        self._tolerance = np.array([one or 0.0 for one in tolerances])
        self._fastest = np.array([joint.velocity_limit for joint in self._robot.joints])
        self.found = Simulated()

    def run(self, rows: int, on_progress: Callable[[str], None]) -> Simulated:
        """Episodes of one attack after the other until so many rows were executed."""
        names = attacks_on(self._robot)
        while self.found.rows < rows:
            number = self._seed + self.found.episodes
            self.episode(names[number % len(names)], EPISODES_MOST * self._seed + number)
            on_progress(
                f"{self._robot.id}: {self.found.rows} of {rows} rows executed, breaches "
                f"{dict(self.found.breaches)}, stops {dict(self.found.stops)}"
            )
        return self.found

    def episode(self, name: str, seed: int, most_ticks: int | None = None) -> None:
        """One episode, by default a whole one, and where the robot comes to rest after it."""
        found, loop = self.found, self._loop
        attack = make_attack(self._robot, name, seed, self._arena)
        ticks = attack.ticks if most_ticks is None else most_ticks
        loop.begin(seed, attack.claims)
        found.episodes += 1
        self._name, self._broken = f"{self._robot.id} {name} {seed}", set[str]()
        while loop.tick <= ticks and not loop.stop_cause:
            for source in loop.undecided:
                self._ask(attack, source)
            done = loop.advance(name)
            if done is not None:
                found.by_attack[name] += bool(done.commands)
                found.cut.update(one.code for one in loop.take_cut())
                self._check(name, done)
        if loop.stop_cause:
            found.stops[kind_of(loop.stop_cause)] += 1
            self._tell(story_of(loop.stop_cause))
        for _ in range(REST_TICKS):
            self._check(name, loop.hold(name))

    def _ask(self, attack: Attack, source: str) -> None:
        loop = self._loop
        rows = attack.chunk(source, loop.now, loop.tick)
        verdict = loop.propose(rows, source)
        self.found.chunks += 1
        if verdict.outcome == Outcome.REFUSED:
            self.found.refused[verdict.code] += 1
            attack.answered(source, None)
            return
        if verdict.outcome == Outcome.TRUNCATED:
            self.found.truncated[verdict.code] += 1
        attack.answered(source, rows[verdict.released_last - loop.tick])

    def _check(self, name: str, done: Tick) -> None:
        found = self.found
        found.rows += bool(done.commands)
        found.held += not done.commands
        for rule, room in self._rooms(done.after.positions, done.after.velocities).items():
            found.worst[rule] = min(found.worst[rule], room)
            if not room >= 0.0:
                found.breaches[rule] += 1
                modes = {part: told.mode.yaml_name for part, told in done.commands.items()}
                arms = [self._robot.part(part) for part in modes]
                found.idle[rule] += all(len(part.joints) < ARM_JOINTS for part in arms)
                if rule not in self._broken:
                    self._broken.add(rule)
                    found.broken[f"{name}: {rule}"] += 1
                    self._tell(f"{rule} {room:.4f}{self._joint(rule, done)}, {modes}")

    def _rooms(self, q: FloatArray, speeds: FloatArray) -> dict[str, float]:
        rooms = {rule: float(room[0]) for rule, room in self._arena.room(q[None, :]).items()}
        own = q[: len(self._tolerance)]
        room = np.minimum(own - self._arena.lower, self._arena.upper - own) + self._tolerance
        rooms["bounds"] = float(room.min())
        rooms[SPEED] = float(self._speed_room(speeds).min())
        return rooms

    def _speed_room(self, speeds: FloatArray) -> FloatArray:
        """Of each commanded joint [rad/s or m/s]; below 0 beyond its declared limit."""
        most = self._fastest * (1.0 + SPEED_TOLERANCE)
        return np.asarray(most - np.abs(speeds[: len(most)]))

    def _joint(self, rule: str, done: Tick) -> str:
        worst = int(np.argmin(self._speed_room(done.after.velocities)))
        return f" {self._robot.joint_names[worst]}" if rule == SPEED else ""

    def _tell(self, what: str) -> None:
        self.found.told.append(f"{self._name}: tick {self._loop.tick}: {what}")
