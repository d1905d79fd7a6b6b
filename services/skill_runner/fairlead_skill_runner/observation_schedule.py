"""Realtime: at which tick the next observation is taken, so that the rows never run out."""

from __future__ import annotations

from collections import deque

from fairlead.messages import Outcome, Verdict
from fairlead_skill_runner.chunk_tracker import SentChunk
from fairlead_skill_runner.seam import SPARE_TICKS

REMEMBERED = 16
"""Answers whose delay counts: the longest of them is expected again."""


class ObservationSchedule:
    """Plans from each chunk when it is sent, and again when the gate has judged it.

    A delay goes from an observation to the first row of its answer that can act. That of the
    goal's first answer counts only until there is a second: a policy compiles, caches fill.

    Args:
        execute_steps: rows of a chunk that the skill means to be executed.

    Attributes:
        next_tick: the earliest tick to observe; 0 before the first chunk: at once.
    """

    def __init__(self, execute_steps: int) -> None:
        self._execute_steps = execute_steps
        self._delays: deque[int] = deque(maxlen=REMEMBERED)
        self._answers = 0
        self._unjudged_seq = 0  # the newest chunk, before the gate's first word on it
        self.next_tick = 0

    @property
    def delay_ticks(self) -> int:
        """The longest of the last delays; 1 before the first answer."""
        return max(self._delays, default=1)

    def sent(self, chunk: SentChunk, now_tick: int) -> None:
        """Suppose that all rows after ``now_tick`` will be released."""
        self._answers += 1
        if self._answers == 2:  # the first was the cold start
            self._delays.clear()
        self._delays.append(max(0, now_tick + 1 - chunk.obs_tick))
        self._unjudged_seq = chunk.seq
        self._plan(chunk, chunk.horizon)

    def judged(self, chunk: SentChunk, verdict: Verdict) -> None:
        """Count on the rows that were released; after a refusal observe at once."""
        if verdict.outcome == Outcome.REFUSED:
            self.next_tick = chunk.obs_tick + 1
            return
        # Rows that are judged again later say nothing of how long the answer took.
        if verdict.seq == self._unjudged_seq and verdict.released_first:
            self._delays[-1] = max(self._delays[-1], verdict.released_first - chunk.obs_tick)
            self._unjudged_seq = 0
        self._plan(chunk, verdict.released_last - chunk.obs_tick + 1)

    def _plan(self, chunk: SentChunk, rows: int) -> None:
        delay = self.delay_ticks
        spacing = rows - delay - SPARE_TICKS
        # A second spare tick, for two mishaps at once, where the policy need not hurry for it.
        spacing -= spacing > delay
        self.next_tick = chunk.obs_tick + max(1, min(self._execute_steps, spacing))
