"""G001 to G006 and G010 on a sequence of messages of one runner, from its rules, not its code.

Only what one claim hears is modelled: rows are taken to be good ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from bench.equipment.case import Pacing
from fairlead.messages import ActionChunk
from tests.differential.fault import Fault
from tests.differential.reference import open_tick

SEQ_JUMP_MAX = 1000
FAR_AHEAD_TO_STOP = 5
BAD_FRAMES_TO_END = 5
WINDOW_TICKS = 20
RATE_WINDOW_S = 0.25
RATE_ROOM = 1.2


@dataclass(frozen=True)
class Reply:
    """What a candidate is answered.

    verdict: False where there is none yet, because the chunk waits for the next state.
    copy_of: the reply that must come again, word for word. names_claim: whether the verdict
    carries the claim's id. stops: whether the gate stops.
    """

    verdict: bool = True
    fault: Fault | None = None
    copy_of: int = 0
    names_claim: bool = True
    stops: bool = False


@dataclass
class Protocol:
    """The gate's memory of one claim.

    seq: of the newest chunk that got past G005; past: that of each source before it. replies: how
    many verdicts there were. decided_tick: when the newest chunk was judged. released_until: last
    tick with a row.
    """

    pacing: Pacing
    tick: int
    session: int
    robot_hash: bytes
    source: str
    age_max_ticks: int
    chunk_rate_hz: float
    period_s: float
    epoch: int = 0
    claim_id: int = 0
    seq: int = 0
    past: dict[str, int] = field(default_factory=dict)
    newest: bytes = b""
    newest_reply: int = 0
    waiting: tuple[bytes, ActionChunk] | None = None
    counted: list[int] = field(default_factory=list)
    far_ahead: list[int] = field(default_factory=list)
    bad_frames: list[int] = field(default_factory=list)
    decided_tick: int = 0
    released_until: int = 0
    replies: int = 0

    def on_claim(self, epoch: int, claim_id: int) -> None:
        """A claim was given: nothing of the one before counts any more."""
        self.epoch, self.claim_id = epoch, claim_id
        self.seq, self.newest, self.waiting, self.past = 0, b"", None, {}
        self.counted, self.bad_frames, self.far_ahead = [], [], []
        self.decided_tick = self.released_until = 0

    def on_hand_over(self, source: str) -> None:
        """The claim was offered to a source that took it: it "goes on under the same id", and what
        was released and decided stands, a source's numbers rise; the rest is a new claim's, unless
        its source is the same."""
        before = self.decided_tick, self.released_until
        counts = self.counted, self.bad_frames, self.far_ahead
        past = {**self.past, self.source: self.seq}
        self.on_claim(self.epoch, self.claim_id)
        if source == self.source:
            self.counted, self.bad_frames, self.far_ahead = counts
        self.source, self.seq, self.past = source, past.get(source, 0), past
        self.decided_tick, self.released_until = before

    def on_bad_frame(self, *, cites_claim: bool) -> Reply:
        """ "G001 refuse; repeated: the claim ends" ("by five malformed frames in 20 ticks that
        begin as its own do")."""
        if not cites_claim or self.claim_id == 0:
            return self._verdict(Fault(1, -1, "", "frame"), names_claim=False)
        self.bad_frames = self._recent([*self.bad_frames, self.tick])
        if len(self.bad_frames) >= BAD_FRAMES_TO_END:
            self.claim_id, self.waiting = 0, None
        return self._verdict(Fault(1, -1, "", "frame"), self.claim_id != 0)

    def on_candidate(self, key_source: str, frame: bytes, chunk: ActionChunk) -> Reply:
        """The reply to a well-formed chunk."""
        fault = self._whose(key_source, chunk)
        if fault is not None:
            return self._verdict(fault, self._is_its_own(key_source, chunk))
        if frame == self.newest:
            return Reply(copy_of=self.newest_reply)
        if chunk.obs_tick == self.tick + 1 and self._sequence(chunk) is None:
            replaced = self.waiting is not None and self.waiting[0] != frame
            self.waiting = (frame, chunk)
            return self._verdict(Fault(6, -1, "", "obs_tick")) if replaced else Reply(verdict=False)
        return self._judged(frame, chunk)

    def on_state(self, tick: int) -> Reply | None:
        """The next state; what it answers is the chunk that waited for it, if one did."""
        self.tick = tick
        if self.waiting is None:
            return None
        (frame, chunk), self.waiting = self.waiting, None
        return self._judged(frame, chunk)

    def _whose(self, key_source: str, chunk: ActionChunk) -> Fault | None:
        """G002 to G004."""
        if chunk.session != self.session:
            return Fault(2, -1, "", "session")
        if chunk.robot_hash != self.robot_hash:
            return Fault(2, -1, "", "robot_hash")
        if chunk.epoch != self.epoch:
            return Fault(3, -1, "", "epoch")
        if chunk.claim_id != self.claim_id or self.claim_id == 0:
            return Fault(4, -1, "", "claim_id")
        if not chunk.source == key_source == self.source:
            return Fault(4, -1, "", "source")
        return None

    def _is_its_own(self, key_source: str, chunk: ActionChunk) -> bool:
        """ "names a claim only if the chunk was that claim's by session, epoch and source"."""
        its = (chunk.session, chunk.epoch, chunk.claim_id) == (
            self.session,
            self.epoch,
            self.claim_id,
        )
        return its and self.claim_id != 0 and chunk.source == key_source == self.source

    def _sequence(self, chunk: ActionChunk) -> Fault | None:
        """ "G005 sequence number strictly rising, jump at most 1,000"."""
        if chunk.seq <= self.seq:
            return Fault(5, -1, "", "seq", chunk.seq, self.seq + 1)
        if chunk.seq - self.seq > SEQ_JUMP_MAX:
            return Fault(5, -1, "", "seq", chunk.seq - self.seq, SEQ_JUMP_MAX)
        return None

    def _judged(self, frame: bytes, chunk: ActionChunk) -> Reply:
        fault = self._sequence(chunk)
        if fault is not None:
            return self._verdict(fault)
        self.seq, self.newest = chunk.seq, frame
        fault = self._ticks(chunk)
        stops = False
        if fault is not None and fault.axis == "obs_tick":
            self.far_ahead = self._recent([*self.far_ahead, self.tick])
            stops = len(self.far_ahead) >= FAR_AHEAD_TO_STOP
        fault = fault or self._rate() or self._past(chunk)
        if fault is None:
            self.released_until = chunk.start_tick + chunk.horizon - 1
        self.decided_tick = self.tick
        reply = self._verdict(fault, stops=stops)
        self.newest_reply = self.replies
        return reply

    def _past(self, chunk: ActionChunk) -> Fault | None:
        """ "G012 at least one row not yet past"."""
        last, start = chunk.start_tick + chunk.horizon - 1, open_tick(self.pacing, self.tick)
        if last < start:
            return Fault(12, -1, "", "last row's tick", last, start)
        return None

    def _is_needed(self) -> bool:
        """ "in lockstep a chunk that the waiting world needs is no excess": for the newest tick
        there is neither a row nor a refusal."""
        is_decided = self.decided_tick == self.tick or self.released_until >= self.tick
        return self.pacing == "lockstep" and not is_decided

    def _ticks(self, chunk: ActionChunk) -> Fault | None:
        """ "G006 obs_tick not newer than the newest state, oldest_tick not newer than it, age
        within the skill's limit"."""
        age = self.tick - chunk.oldest_tick
        start = open_tick(self.pacing, self.tick)
        if chunk.obs_tick > self.tick:
            return Fault(6, -1, "", "obs_tick", chunk.obs_tick, self.tick)
        if chunk.oldest_tick > chunk.obs_tick:
            return Fault(6, -1, "", "oldest_tick", chunk.oldest_tick, chunk.obs_tick)
        if age > self.age_max_ticks:
            return Fault(6, -1, "", "age", age, self.age_max_ticks)
        if chunk.start_tick > start:
            return Fault(6, -1, "", "start_tick", chunk.start_tick, start)
        return None

    def _rate(self) -> Fault | None:
        """ "G010 chunk rate as claimed": in a window of 250 ms, or of two chunks if that is longer,
        a fifth more than the rate, and one."""
        if self._is_needed():
            return None
        window_s = max(RATE_WINDOW_S, 2.0 / self.chunk_rate_hz)
        window = math.ceil(window_s / self.period_s - 1e-9)
        most = math.ceil(RATE_ROOM * self.chunk_rate_hz * window_s - 1e-9) + 1
        self.counted = [tick for tick in self.counted if tick > self.tick - window]
        if len(self.counted) >= most:
            return Fault(10, -1, "", "chunks", len(self.counted) + 1, most)
        self.counted.append(self.tick)
        return None

    def _recent(self, ticks: list[int]) -> list[int]:
        return [tick for tick in ticks if tick > self.tick - WINDOW_TICKS]

    def _verdict(self, fault: Fault | None, names_claim: bool = True, stops: bool = False) -> Reply:
        self.replies += 1
        return Reply(fault=fault, names_claim=names_claim, stops=stops)
