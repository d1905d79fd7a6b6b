"""What rows would do under ideal conditions, tick by tick: the theory, and two other executors.

All take latencies in ticks, in the order of the answers, and need no robot. A level is the number
that every row of an answer says. None is a tick without a row.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

PHASES = 64
THRESHOLD = 0.5
"""LeRobot's default `chunk_size_threshold`: ask when so little of a chunk is left."""


@dataclass(frozen=True)
class Executed:
    """What each tick executed."""

    levels: Sequence[float | None]

    @property
    def stalls(self) -> int:
        """Ticks without a row."""
        return sum(level is None for level in self.levels)

    @property
    def duty(self) -> float:
        """Share of the ticks that have one."""
        return 1.0 - self.stalls / len(self.levels) if self.levels else 0.0

    @property
    def largest_step(self) -> float:
        """From one tick to the next, both with a row."""
        steps = [abs(b - a) for a, b in pairwise(self.levels) if a is not None and b is not None]
        return max(steps, default=0.0)


def theory(
    latencies: Sequence[float], horizon: int, lost: float = 0.0, ways: tuple[float, float] = (0, 0)
) -> float:
    """The duty of one question at a time, asked again at once, where nothing else costs time.

    An answer to the observation of tick o that takes L ticks from the moment a (o = floor(a)) has
    its first row in tick floor(a + L) + 1 and its last in o + horizon - 1. By the renewal-reward
    theorem duty is the mean number of rows that act for one answer over the mean time between
    answers: for a constant L, and moments that fall anywhere in a tick,
    min(1, (horizon - 1 - L) / L). No executor that asks one question at a time has more, for it
    cannot ask earlier. This is the same for the latencies there were, the mean over where in a
    tick the first was asked.

    Args:
        lost: probability of a message. A lost observation is the one a tick older, a lost chunk
            comes a tick later.
        ways: ticks from the robot's state to the question, and from the answer to the robot.
    """
    rng = random.Random(0)
    duties = [
        _asked_at(number / PHASES, latencies, horizon, ways, lambda: rng.random() < lost)
        for number in range(PHASES)
    ]
    return sum(duties) / PHASES


def _asked_at(
    moment: float,
    latencies: Sequence[float],
    horizon: int,
    ways: tuple[float, float],
    is_lost: Callable[[], bool],
) -> float:
    covered: set[int] = set()
    begins: list[int] = []
    for latency in latencies:
        last = math.floor(moment - ways[0]) - is_lost() + horizon - 1
        moment += latency
        begins.append(math.floor(moment + ways[1]) + 1 + is_lost())
        covered |= set(range(begins[-1], last + 1))
    ticks = range(begins[0], begins[-1])
    return sum(tick in covered for tick in ticks) / len(ticks) if ticks else 1.0


def synchronous(latencies: Sequence[float], levels: Sequence[float], horizon: int) -> Executed:
    """Ask, wait, execute all rows from the first, ask again.

    What openpi's `ActionChunkBroker` does where all rows are executed: its client asks when the
    rows are used up and the robot waits for the answer.
    """
    done: list[float | None] = []
    for latency, level in zip(latencies, levels, strict=True):
        done += [None] * math.ceil(latency)
        done += [level] * horizon
    return Executed(done[math.ceil(latencies[0]) :])


def latest_wins(latencies: Sequence[float], levels: Sequence[float], horizon: int) -> Executed:
    """A queue of rows by tick, in which a newer answer replaces an older one's.

    LeRobot's asynchronous client with the aggregate function `latest_only`, as its documentation
    describes it: it asks when at most `THRESHOLD` of a chunk is left in the queue, one question
    at a time here; rows of an answer whose tick has passed are dropped, all others replace the
    queue's. It knows nothing of how long an answer takes.
    """
    queue: dict[int, float] = {}
    due: tuple[float, int, float] | None = None
    answers = iter(zip(latencies, levels, strict=True))
    done: list[float | None] = []
    tick = 0
    while True:
        if due is not None and due[0] <= tick:
            _, asked, level = due
            queue = dict.fromkeys(range(max(tick, asked), asked + horizon), level)
            due = None
        if due is None and len(queue) <= THRESHOLD * horizon:
            following = next(answers, None)
            if following is None:
                break
            due = tick + following[0], tick, following[1]
        done.append(queue.pop(tick, None))
        tick += 1
    begun = next((at for at, level in enumerate(done) if level is not None), len(done))
    return Executed(done[begun:])
