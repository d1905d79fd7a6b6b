"""Adversarial chunks through the real core into a real simulator, tick by tick."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from bench.measure_limits.driven_robot import Tick
from fairlead.messages import FloatArray, Outcome
from tests.soundness.adversary import KINDS, Adversary
from tests.soundness.arena import RULES, Arena
from tests.soundness.chunk_rows import Row
from tests.soundness.lockstep_loop import LockstepLoop
from tests.soundness.stops import kind_of, story_of

EPISODE_TICKS = 90
EPISODES_MOST = 10_000
ARM_JOINTS = 6
HELD_MOST = 10
"""Chunks refused in a row after which an episode is over."""


@dataclass
class Simulated:
    """rows: executed in ticks, of one chunk each. stops: by code and joint. breaches: ticks by
    rule. told: the first of both.

    idle: those of the breaches in which no arm was told anything. worst: least room measured, by
    rule; of bounds beyond their tolerance.
    """

    episodes: int = 0
    chunks: int = 0
    rows: int = 0
    held: int = 0
    refused: Counter[int] = field(default_factory=Counter)
    truncated: Counter[int] = field(default_factory=Counter)
    stops: Counter[str] = field(default_factory=Counter)
    breaches: Counter[str] = field(default_factory=Counter)
    idle: Counter[str] = field(default_factory=Counter)
    worst: dict[str, float] = field(default_factory=lambda: dict.fromkeys(RULES, np.inf))
    told: list[str] = field(default_factory=list)


class SimulatedCampaign:
    """One robot; recorded as for `KinematicCampaign`. Each seed has episodes of its own."""

    def __init__(self, loop: LockstepLoop, recorded: Sequence[Row], seed: int = 1) -> None:
        self._loop, self._robot = loop, loop.driven.robot
        self._first = EPISODES_MOST * (seed - 1)
        self._rng = np.random.default_rng(seed)
        self._adversary = Adversary(self._robot, recorded, self._rng)
        self._arena = Arena(loop.file)
        measured = self._robot.profile("sim").measured
        tolerances = [measured[name].tolerance for name in self._robot.joint_names]
        self._tolerance = np.array([one or 0.0 for one in tolerances])
        self.found = Simulated()

    def run(self, rows: int, on_progress: Callable[[str], None]) -> Simulated:
        """Episodes until so many rows were executed."""
        while self.found.rows < rows:
            self._episode()
            on_progress(
                f"{self._robot.id}: {self.found.rows} of {rows} rows executed, breaches "
                f"{dict(self.found.breaches)}, stops {dict(self.found.stops)}"
            )
        return self.found

    def _episode(self) -> None:
        found, loop = self.found, self._loop
        loop.begin(self._first + found.episodes)
        kind = KINDS[(self._first + found.episodes) % len(KINDS)]
        found.episodes += 1
        self._adversary.begin(kind)
        refused = 0
        while loop.tick <= EPISODE_TICKS and refused < HELD_MOST:
            done = loop.advance(kind)
            if done is not None:
                self._check(kind, done)
            elif loop.stop_cause:
                found.stops[kind_of(loop.stop_cause)] += 1
                found.told.append(f"{self._where(kind)}: {story_of(loop.stop_cause)}")
                return
            else:
                refused = 0 if self._ask() else refused + 1

    def _ask(self) -> bool:
        loop = self._loop
        rows = self._adversary.chunk(loop.now)
        verdict = loop.propose(rows)
        self.found.chunks += 1
        if verdict.outcome == Outcome.REFUSED:
            self.found.refused[verdict.code] += 1
            self._adversary.go_on_after(None)
            return False
        if verdict.outcome == Outcome.TRUNCATED:
            self.found.truncated[verdict.code] += 1
        self._adversary.go_on_after(rows[verdict.released_last - loop.tick])
        return True

    def _check(self, kind: str, done: Tick) -> None:
        found = self.found
        found.rows += bool(done.commands)
        found.held += not done.commands
        q = done.after.positions[None, :]
        rooms = {rule: float(room[0]) for rule, room in self._arena.room(q).items()}
        rooms["bounds"] = self._within_tolerance(q[0])
        for rule, room in rooms.items():
            found.worst[rule] = min(found.worst[rule], room)
            if room < 0.0:
                found.breaches[rule] += 1
                modes = {part: told.mode.yaml_name for part, told in done.commands.items()}
                arms = [self._robot.part(part) for part in modes]
                found.idle[rule] += all(len(part.joints) < ARM_JOINTS for part in arms)
                found.told.append(f"{self._where(kind)}: {rule} {room:.4f}, {modes}")

    def _where(self, kind: str) -> str:
        episode = self._first + self.found.episodes - 1
        return f"episode {episode}, tick {self._loop.tick}, {kind}"

    def _within_tolerance(self, q: FloatArray) -> float:
        own = q[: len(self._tolerance)]
        room = np.minimum(own - self._arena.lower, self._arena.upper - own) + self._tolerance
        return float(room.min())
