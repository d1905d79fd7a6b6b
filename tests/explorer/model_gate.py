"""A model of the gate's protocol, not of its checks: one claim, one limit on base speed.

It lets the explorer run where the real core has not been built. What it knows: epochs,
leases, decisions, verdicts, stops, and judging again when the HAL did something else.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field

import msgspec
import numpy as np

from fairlead.messages import (
    NO_HASH,
    Acted,
    ActionChunk,
    ActionPart,
    Arm,
    ArmReply,
    Claim,
    ClaimReply,
    Decision,
    Done,
    GateState,
    GateStatus,
    Grant,
    HalStatus,
    Hold,
    JointState,
    Lease,
    Message,
    Outcome,
    Refusal,
    Release,
    Reset,
    SafeChunk,
    StopLevel,
    Verdict,
    decode,
    encode,
    floats,
    pack_floats,
)
from tests.explorer.gate_port import EventKind, GateOutput, OutputKind

LEASE_INTERVAL_NS = 25_000_000
SPEED_LIMIT = 1.0
HOLD = Acted(hold=Hold.NO_ROW, verdict_id=0, row=0)


@dataclass
class _Claim:
    claim_id: int
    source: str
    seq: int = 0
    frame: bytes = b""
    chunk: ActionChunk | None = None
    verdict: Verdict | None = None
    release: SafeChunk | None = None
    releases: dict[int, SafeChunk] = field(default_factory=dict)
    refused_tick: int = 0
    waiting: bytes = b""


class ModelGate:
    """Implements `tests.explorer.gate_port.GatePort`."""

    def __init__(self, seed: int, restarted: bool = False) -> None:
        self._random = random.Random(2 * seed + restarted)
        self._state = GateState.DISARMED
        self._epoch = self._id()
        self._lease_seq = 0
        self._lease_ns = -LEASE_INTERVAL_NS
        self._session = 0
        self._lockstep = False
        self._period_ns = 50_000_000
        self._joints: JointState | None = None
        self._claim: _Claim | None = None
        self._stops: list[int] = []
        self._reset: set[int] = set()
        self._verdict_id = self._id() % 2**40
        self._out: list[GateOutput] = []

    def close(self) -> None:
        """Nothing to release."""

    def step(
        self, now_ns: int, kind: EventKind, source: str = "", payload: bytes = b""
    ) -> list[GateOutput]:
        self._out = []
        lease_due = now_ns - self._lease_ns >= LEASE_INTERVAL_NS
        if kind == "joint_state":
            lease_due |= self._on_state(decode(JointState, payload))
        elif kind == "candidate":
            self._on_candidate(decode(ActionChunk, payload), payload)
            lease_due = True
        elif kind == "hal_status":
            status = decode(HalStatus, payload)
            self._session = self._session or status.session
            self._lockstep = status.pacing == "lockstep"
        elif kind == "stop_level":
            lease_due |= self._on_stop(decode(StopLevel, payload).stop_id)
        elif kind not in ("timer", "heartbeat"):
            self._on_query(kind, payload)
            lease_due = True
        if lease_due and self._session:
            self._publish_lease(now_ns)
        return self._out

    @property
    def _tick(self) -> int:
        return self._joints.tick if self._joints else 0

    def _id(self) -> int:
        return self._random.randrange(1, 2**63)

    def _put(self, kind: OutputKind, message: Message, source: str = "") -> None:
        self._out.append(GateOutput(kind, source, encode(message)))

    # The robot

    def _on_state(self, joints: JointState) -> bool:
        if joints.session != self._session or joints.tick < self._tick:
            return False
        is_new = joints.tick > self._tick
        self._joints = joints
        claim = self._claim
        if is_new and claim is not None:
            if claim.waiting:
                frame, claim.waiting = claim.waiting, b""
                self._on_candidate(decode(ActionChunk, frame), frame)
            if not self._hal_follows(claim):
                self._judge_again(claim)
        return True

    def _acted(self) -> Acted:
        """What the claim's part (the base) did in the tick before the newest state."""
        assert self._joints is not None
        return self._joints.acted[2]

    def _hal_follows(self, claim: _Claim) -> bool:
        release, before = claim.release, self._tick - 1
        if release is None or release.first_tick > before:
            return True
        row = before - release.first_tick
        if row >= release.horizon:
            return True
        return self._acted() == Acted(hold=0, verdict_id=release.verdict_id, row=row)

    def _expected(self, claim: _Claim, tick: int) -> Acted:
        """What the claim's parts do in ``tick``: the last measured act, or one tick on."""
        acted = self._acted()
        if tick == self._tick - 1:
            return acted
        newest = claim.release
        if newest and newest.first_tick == tick and _same(newest.after, acted):
            return Acted(hold=0, verdict_id=newest.verdict_id, row=0)
        running = claim.releases.get(acted.verdict_id) if not acted.hold else None
        if running and acted.row + 1 < running.horizon:
            return Acted(hold=0, verdict_id=acted.verdict_id, row=acted.row + 1)
        return HOLD

    # Chunks

    def _on_candidate(self, chunk: ActionChunk, frame: bytes) -> None:
        claim = self._claim
        if (
            claim is None
            or self._state != GateState.ARMED
            or (chunk.session, chunk.epoch, chunk.claim_id)
            != (self._session, self._epoch, claim.claim_id)
        ):
            return
        if chunk.obs_tick > self._tick:
            claim.waiting = frame
            return
        if frame == claim.frame and claim.verdict is not None:
            self._put("verdict", claim.verdict, claim.source)
            return
        if chunk.seq <= claim.seq:
            return
        claim.seq, claim.frame, claim.chunk = chunk.seq, frame, chunk
        self._judge(claim, chunk, self._next_verdict())
        assert claim.verdict is not None
        self._put("verdict", claim.verdict, claim.source)

    def _judge_again(self, claim: _Claim) -> None:
        if claim.chunk is not None and claim.release is not None:
            self._judge(claim, claim.chunk, self._next_verdict(), again=True)

    def _judge(
        self, claim: _Claim, chunk: ActionChunk, verdict_id: int, again: bool = False
    ) -> None:
        first = max(chunk.start_tick, self._tick if self._lockstep else self._tick + 1)
        kept = _rows_within_limit(chunk, first - chunk.start_tick)
        if kept and first - 1 <= self._tick:
            safe = self._safe_chunk(claim, chunk, verdict_id, first, kept)
            claim.release = claim.releases[verdict_id] = safe
        elif not again:
            kept = 0
            claim.refused_tick = self._tick
        if not again:
            claim.verdict = self._verdict(chunk, verdict_id, first, kept)

    def _safe_chunk(
        self, claim: _Claim, chunk: ActionChunk, verdict_id: int, first: int, kept: int
    ) -> SafeChunk:
        begin = first - chunk.start_tick
        return SafeChunk(
            session=self._session,
            epoch=self._epoch,
            claim_id=claim.claim_id,
            source=claim.source,
            verdict_id=verdict_id,
            judged_tick=self._tick,
            first_tick=first,
            horizon=kept,
            after=self._expected(claim, first - 1),
            parts=tuple(_cut(part, chunk.horizon, begin, kept) for part in chunk.parts),
        )

    def _verdict(self, chunk: ActionChunk, verdict_id: int, first: int, kept: int) -> Verdict:
        outcome = Outcome.RELEASED if kept == chunk.horizon else Outcome.TRUNCATED
        return Verdict(
            verdict_id=verdict_id,
            session=self._session,
            epoch=self._epoch,
            claim_id=chunk.claim_id,
            source=chunk.source,
            seq=chunk.seq,
            outcome=outcome if kept else Outcome.REFUSED,
            code=0 if kept == chunk.horizon else 20,
            row=-1,
            part="",
            axis="",
            value=0.0,
            limit=0.0,
            margin=0.0,
            limit_source="",
            released_first=first if kept else 0,
            released_last=first + kept - 1 if kept else 0,
            config_hash=NO_HASH,
            latency_ns=0,
        )

    def _next_verdict(self) -> int:
        self._verdict_id += 1
        return self._verdict_id

    # Stops and queries

    def _on_stop(self, stop_id: int) -> bool:
        if stop_id in self._reset or stop_id in self._stops:
            return False
        self._stops.append(stop_id)
        self._state, self._claim = GateState.STOPPED, None
        return True

    def _on_query(self, kind: EventKind, payload: bytes) -> None:
        if kind == "arm" and self._state == GateState.DISARMED:
            decode(Arm, payload)
            self._state, self._epoch, self._lease_seq = GateState.ARMED, self._id(), 0
            self._put("reply", ArmReply(epoch=self._epoch, session=self._session))
        elif kind == "claim" and self._state == GateState.ARMED:
            request = decode(Claim, payload)
            self._claim = _Claim(self._id(), request.source)
            reply = ClaimReply(
                claim_id=self._claim.claim_id, epoch=self._epoch, session=self._session
            )
            self._put("reply", reply)
        elif kind == "reset" and self._state == GateState.STOPPED:
            stop_id = decode(Reset, payload).id
            self._reset.add(stop_id)
            self._stops = [held for held in self._stops if held != stop_id]
            self._state = GateState.STOPPED if self._stops else GateState.DISARMED
            self._put("reply", Done(text="reset"))
        elif kind == "release":
            decode(Release, payload)
            self._claim = None
            self._put("reply", Done(text="released"))
        elif kind == "status":
            self._put("reply", self._status())
        else:
            text = f"{kind} while {self._state.name}"
            self._put("refusal", Refusal(who="model", reason=text, fix=""))

    def _status(self) -> GateStatus:
        return GateStatus(
            robot="model",
            profile="sim",
            session=self._session,
            epoch=self._epoch,
            state=self._state,
            cause="",
            fix="",
            latch_id=0,
            stop_ids=tuple(self._stops),
            claims=(),
            counters=(),
            state_tick=self._tick,
            lockstep_allowed=True,
            config_hash=NO_HASH,
            robot_hash=NO_HASH,
        )

    # Leases

    def _publish_lease(self, now_ns: int) -> None:
        self._lease_ns = now_ns
        self._lease_seq += 1
        claim = self._claim
        if claim is not None and claim.release is not None:
            self._put("safe_chunk", claim.release, claim.source)
        lease = Lease(
            session=self._session,
            epoch=self._epoch,
            lease_seq=self._lease_seq,
            config_hash=NO_HASH,
            state=self._state,
            state_tick=self._tick,
            grants=(self._grant(claim),) if claim else (),
            stop_ids=tuple(self._stops),
        )
        self._put("lease", lease)

    def _grant(self, claim: _Claim) -> Grant:
        tick, release = self._tick, claim.release
        decision, verdict_id = Decision.UNDECIDED, 0
        if release and 0 <= tick - release.first_tick < release.horizon:
            decision, verdict_id = Decision.ROW, release.verdict_id
        if claim.refused_tick == tick:
            decision = Decision.HOLD
        until = tick if self._lockstep else tick + max(2, -(-75_000_000 // self._period_ns))
        return Grant(
            source=claim.source,
            claim_id=claim.claim_id,
            until_tick=until,
            decision=decision,
            verdict_id=verdict_id,
        )


def _same(a: Acted, b: Acted) -> bool:
    return bool(a.hold and b.hold) or a == b


def _rows_within_limit(chunk: ActionChunk, begin: int) -> int:
    """How many rows from ``begin`` on stay within the limit before the first that does not."""
    speeds = np.abs(floats(chunk.parts[0].values, len(chunk.parts[0].values) // 8 // chunk.horizon))
    kept = 0
    for row in speeds[begin:]:
        if row.max() > SPEED_LIMIT:
            break
        kept += 1
    return kept


def _cut(part: ActionPart, horizon: int, begin: int, kept: int) -> ActionPart:
    rows = floats(part.values, len(part.values) // 8 // horizon)[begin : begin + kept]
    return msgspec.structs.replace(part, values=pack_floats(rows))
