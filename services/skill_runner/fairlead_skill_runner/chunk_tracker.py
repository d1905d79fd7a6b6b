"""The newest chunk a runner sent, what the gate said to it, and which rows are released."""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.messages import ActionPart, Outcome, Verdict
from fairlead.wire.verdict_text import describe
from fairlead_skill_runner.seam import ReleasedRows

NEVER_ADMITTED = range(2, 6)
"""G002 to G005: codes of chunks that the gate did not take for this claim's next one."""


CHUNKS_REMEMBERED = 16


@dataclass(frozen=True)
class SentChunk:
    """One chunk as it was sent; ``payload`` is re-sent byte for byte, ``parts`` are its rows."""

    seq: int
    obs_tick: int
    horizon: int
    sent_tick: int
    payload: bytes
    parts: tuple[ActionPart, ...] = ()

    @property
    def last_row_tick(self) -> int:
        """The tick of the last row."""
        return self.obs_tick + self.horizon - 1


class ChunkTracker:
    """Book-keeping of one claim's chunks and verdicts.

    Args:
        period_s: a control period.
        first_seq: above those of the goal before under the same claim: verdicts on its chunks may
            still come.
    """

    def __init__(self, period_s: float, first_seq: int = 1) -> None:
        self._first_seq = first_seq
        self._period_s, self._took_s = period_s, 0.0
        self.newest: SentChunk | None = None
        self.answered = True
        self.released_last = 0
        self._released_seq = 0  # chunk of the released rows
        self._newest_verdict = 0  # verdict ids increase
        self._sent: dict[int, SentChunk] = {}  # by seq: may still be judged, or has rows that act
        self._refused: set[int] = set()
        self._last_refused = ""

    @property
    def next_seq(self) -> int:
        """The number of the chunk to be sent next."""
        return self.newest.seq + 1 if self.newest else self._first_seq

    @property
    def last_obs_tick(self) -> int:
        """Observation tick of the newest chunk; 0 before the first."""
        return self.newest.obs_tick if self.newest else 0

    @property
    def refusals(self) -> str:
        """How many chunks were refused of how many, and the last refusal; "" if none was."""
        if not self._refused or self.newest is None:
            return ""
        sent = self.newest.seq - self._first_seq + 1
        counts = f"{len(self._refused)} of {sent} chunks refused"
        return f"{counts}, the last: {self._last_refused}"

    def obs_tick(self, seq: int) -> int | None:
        """Observation tick of one of the last chunks."""
        return self._sent[seq].obs_tick if seq in self._sent else None

    def released_rows(self) -> ReleasedRows | None:
        """Those that act now and next; None if there are none."""
        chunk = self._sent.get(self._released_seq) if self.released_last else None
        if chunk is None:
            return None
        return ReleasedRows(chunk.parts, chunk.obs_tick, self.released_last)

    def words(self, verdict: Verdict) -> str:
        """A verdict that did not release all, for people; of a policy too slow that it is."""
        text, chunk = describe(verdict), self.newest
        if chunk is None or verdict.seq != chunk.seq:
            return text
        waited = chunk.sent_tick - chunk.obs_tick
        return text + late_words(verdict, waited, self._took_s, self._period_s)

    def sent(self, chunk: SentChunk, took_s: float = 0.0) -> None:
        """Take note of a new chunk: from now on the gate's answer to it is awaited.

        Args:
            took_s: the policy's answer.
        """
        self._took_s = took_s
        self.newest = chunk
        self.answered = False
        self._sent[chunk.seq] = chunk
        oldest = chunk.seq - CHUNKS_REMEMBERED
        for seq in [seq for seq in self._sent if seq <= oldest and seq != self._released_seq]:
            del self._sent[seq]

    def judged(self, verdict: Verdict) -> bool:
        """Take a verdict on this claim; False if it says nothing new.

        A chunk that somebody else put on our key is refused under our claim and perhaps our
        seq: the first verdict of a seq stands.
        """
        if verdict.verdict_id <= self._newest_verdict or self.newest is None:
            return False
        if verdict.seq < self._first_seq:
            return False
        is_awaited = verdict.seq == self.newest.seq and not self.answered
        if verdict.code in NEVER_ADMITTED and not is_awaited:
            return False
        self._newest_verdict = verdict.verdict_id
        if verdict.seq == self.newest.seq:
            self.answered = True
        if verdict.outcome == Outcome.REFUSED:
            self._refused.add(verdict.seq)
            self._last_refused = self.words(verdict)
            # A refused chunk leaves older released rows as they are; but rows that were
            # released and are judged again, because the robot did something else, are gone.
            if verdict.seq == self._released_seq:
                self.released_last = 0
            return True
        self._released_seq = verdict.seq
        self.released_last = verdict.released_last
        return True

    def is_settled(self, tick: int) -> bool:
        """True if the gate has answered the newest chunk, or its rows are all past anyway."""
        return self.answered or self.newest is None or tick > self.newest.last_row_tick

    def due_again(self, tick: int, repeated: bool) -> bytes | None:
        """The bytes to re-send at ``tick``: no verdict after one tick, or the tick came again.

        A tick that comes again although its row counts as released: perhaps the row was
        judged again and refused, and that verdict is lost. The gate answers a copy with the
        newest verdict, at no cost where nothing is amiss.
        """
        chunk = self.newest
        if chunk is None:
            return None
        if repeated and (chunk.obs_tick == tick or tick <= self.released_last):
            return chunk.payload
        late = not self.answered and (tick > chunk.sent_tick or repeated)
        return chunk.payload if late and tick <= chunk.last_row_tick else None


TOO_OLD = 6
"""G006."""


def late_words(verdict: Verdict, waited_ticks: int, took_s: float, period_s: float) -> str:
    """To go behind a verdict's words; "" where no slow policy is the cause.

    Args:
        waited_ticks: from the observation to the chunk.
        took_s: the policy's answer.
        period_s: a control period.
    """
    if verdict.code != TOO_OLD or verdict.value <= verdict.limit or waited_ticks <= 0:
        return ""
    # The rest of the age: inputs that were old when the policy was asked, and the way to the gate.
    may_s = max(0.0, verdict.limit - (verdict.value - waited_ticks)) * period_s
    return (
        f"; the policy is slow: it answered after {took_s:.2f} s and has {may_s:.2f} s: "
        f"age_max_ticks, {verdict.limit:g} of {period_s * 1000:g} ms, less the age of its inputs"
    )
