"""Realtime: at which tick the next observation is taken, so that the rows never run out."""

from __future__ import annotations

from fairlead.messages import Outcome, Verdict
from fairlead_skill_runner.chunk_tracker import SentChunk


class ObservationSchedule:
    """Plans from each chunk when it is sent, and again when the gate has judged it.

    Args:
        execute_steps: rows of a chunk that the skill means to be executed.

    Attributes:
        next_tick: the earliest tick to observe; 0 before the first chunk: at once.
    """

    def __init__(self, execute_steps: int) -> None:
        self._execute_steps = execute_steps
        self.next_tick = 0

    def sent(self, chunk: SentChunk, now_tick: int) -> None:
        """Suppose that all rows after ``now_tick`` will be released."""
        delay = max(0, now_tick + 1 - chunk.obs_tick)
        self._plan(chunk, chunk.horizon, delay)

    def judged(self, chunk: SentChunk, verdict: Verdict, delay_ticks: int) -> None:
        """Count on the rows that were released; after a refusal observe at once.

        Args:
            delay_ticks: ticks from an observation to its first live row, as measured.
        """
        if verdict.outcome == Outcome.REFUSED:
            self.next_tick = chunk.obs_tick + 1
            return
        self._plan(chunk, verdict.released_last - chunk.obs_tick + 1, delay_ticks)

    def _plan(self, chunk: SentChunk, rows: int, delay: int) -> None:
        spare = 1  # pays for one re-send
        spacing = max(1, min(self._execute_steps, rows - delay - spare))
        self.next_tick = chunk.obs_tick + spacing
