"""Several claims at once: each asks for rows of its own parts, whenever it likes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from bench.equipment.case import Pacing
from bench.soundness.adversary import KINDS, Adversary
from bench.soundness.chunk_rows import Row
from bench.soundness.gate_loop import GateLoop
from bench.soundness.share_robot import ShareRobot
from fairlead.messages import FloatArray, Verdict
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment, Tick

TICKS = 40
LOST = 0.4
CHANGES = 0.2
SHORT = 3


def claims_of(robot: RobotManifest) -> dict[str, tuple[str, ...]]:
    """A claim for each part of several joints; a tool's has the composite switch besides."""
    switches = tuple(part.name for part in robot.parts if not part.joints)
    return {
        part.name: (part.name, *(switches if part.end_effector is not None else ()))
        for part in robot.parts
        if len(part.joints) > 1
    }


class SideBySide:
    """One robot's claims, with an attacker for each.

    Args:
        moment: what is measured in a configuration.

    Attributes:
        claims: parts by source; with less than two there is nothing to do side by side.
    """

    def __init__(
        self,
        loop: GateLoop[ShareRobot],
        recorded: Sequence[Row],
        moment: Callable[[FloatArray], Moment],
        rng: np.random.Generator,
    ) -> None:
        robot = loop.driven.robot
        self.claims = claims_of(robot)
        self._loop, self._moment, self._rng = loop, moment, rng
        self._adversaries = {
            source: Adversary(robot, recorded, rng, parts) for source, parts in self.claims.items()
        }

    def ticks(self, pacing: Pacing, on_verdict: Callable[[Verdict], None]) -> Iterator[Tick]:
        """An episode from where the robot is said to begin, until it ends or the gate stops.

        In lockstep each tick waits for the claims that it has no rows of. In realtime they ask as
        often as each run likes, and in some runs the gate misses two states of five.
        """
        self._loop.begin(0, self.claims, pacing)
        for adversary in self._adversaries.values():
            adversary.begin(str(self._rng.choice(KINDS)))
        often = self._rng.uniform(0.1, 0.6)
        lost = LOST * float(pacing == "realtime" and self._rng.random() < 0.6)
        for _ in range(TICKS):
            asking = self._loop.undecided
            if pacing == "realtime":
                asking = tuple(one for one in self.claims if self._rng.random() < often)
            for source in asking:
                on_verdict(self._loop.propose(self._rows(source), source))
            done = self._loop.advance("side by side", is_heard=bool(self._rng.random() >= lost))
            if done is None:
                return
            yield done
            if self._loop.stop_cause:
                return

    def _rows(self, source: str) -> Sequence[Row]:
        adversary = self._adversaries[source]
        if self._rng.random() < CHANGES:
            adversary.begin(str(self._rng.choice(KINDS)))
        adversary.go_on_after(None)
        rows = adversary.chunk(self._moment(self._loop.now.positions))
        is_short = self._rng.random() < 0.5
        return rows[: int(self._rng.integers(1, SHORT + 1))] if is_short else rows
