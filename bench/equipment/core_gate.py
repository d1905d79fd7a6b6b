"""Shows one case to the real core and returns what it said."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from bench.equipment.case import Case, Chunk, Measured, Pacing
from bench.equipment.gate_port import EventKind, GateOutput
from bench.equipment.real_gate import RealGate
from fairlead.messages import (
    NO_TRACE,
    Acted,
    ActionChunk,
    ActionPart,
    Arm,
    ArmReply,
    Claim,
    ClaimReply,
    Disarm,
    Done,
    GateState,
    GateStatus,
    HalPart,
    HalStatus,
    Heartbeat,
    JointState,
    Message,
    Refusal,
    Release,
    SafeChunk,
    StatusQuery,
    Verdict,
    decode,
    encode,
    pack_floats,
)

SESSION = 0x5E5510
SOURCE = "runner"
HELD = Acted(hold=2, verdict_id=0, row=0)
M = TypeVar("M", bound=Message)


class CaseRefusedError(Exception):
    """The gate did not even take what leads up to the chunk: a query was refused."""


@dataclass(frozen=True)
class Answer:
    """What came back for one chunk. stopped: whether the gate raised a stop. outputs: all of it."""

    verdict: Verdict
    safe: SafeChunk | None
    stopped: bool
    chunk: ActionChunk
    outputs: list[GateOutput]


@dataclass(frozen=True)
class CoreReply:
    """What one event was answered. stopped: whether the gate raised a stop. outputs: all of it."""

    verdicts: list[Verdict]
    stopped: bool
    safe: list[SafeChunk] = field(default_factory=list)
    outputs: list[GateOutput] = field(default_factory=list)


class CoreGate:
    """The real core, made new for every case; one process per gate file."""

    def __init__(self, config: Path) -> None:
        self.file: dict[str, Any] = json.loads(config.read_text())
        self._gate = RealGate(seed=1, config=config)
        self._parts = tuple(part["name"] for part in self.file["parts"])
        self._hash = bytes.fromhex(self.file["robot_hash"])
        self._now_ns, self._seq = 0, 0
        self._claims: dict[str, ClaimReply] = {}
        self.has_stopped = False
        self._session = SESSION

    def close(self) -> None:
        """End its process."""
        self._gate.close()

    @property
    def now_ns(self) -> int:
        """The gate's clock."""
        return self._now_ns

    def answers(self, case: Case) -> list[Answer]:
        """The answer to the earlier chunk, if there is one, and to the chunk.

        Raises:
            CaseRefusedError: if the gate does not get as far as judging them.
        """
        first = case.first or case.measured
        self.start(case.pacing, first)
        self.claim(case)
        if case.earlier is None:
            return [self.send(case.chunk, case.measured.tick)]
        earlier = self.send(case.earlier, first.tick)
        self.state(case.measured, self.acted(case, earlier))
        return [earlier, self.send(case.chunk, case.measured.tick)]

    def acted(self, case: Case, earlier: Answer) -> tuple[Acted, ...]:
        """Per part: row 0 of what was released where addressed, unless the HAL held.

        In realtime that row is for the tick that begins only now: until then all held.
        """
        acted = [HELD] * len(self._parts)
        is_past = case.pacing == "lockstep" and not case.held
        if earlier.safe is not None and is_past:
            for part in earlier.safe.parts:
                row = Acted(hold=0, verdict_id=earlier.verdict.verdict_id, row=0)
                acted[part.part] = row
        return tuple(acted)

    def start(self, pacing: Pacing, first: Measured, session: int = SESSION) -> None:
        """A new gate that has met the HAL, is armed at standstill and then sees ``first``."""
        self._gate.boot()
        self._now_ns, self._seq, self.has_stopped = 1_000_000, 0, False
        self._session, self._claims = session, {}
        self._step("hal_status", "", encode(self._status(pacing, first.tick)))
        is_moving = bool(np.any(first.velocities != 0.0))
        still = replace(first, tick=first.tick - 1, velocities=np.zeros_like(first.velocities))
        self.state(still if is_moving else first)
        self.ask("arm", Arm(by="test"), ArmReply)
        if is_moving:
            self.state(first)

    def claim(
        self, case: Case, source: str = SOURCE, parts: tuple[str, ...] | None = None
    ) -> ClaimReply:
        """Claim parts of the robot, by default every one, with the case's limits."""
        request = Claim(
            source=source,
            skill="test",
            skill_hash=bytes(range(32)),
            robot_hash=self._hash,
            period_ns=self.file["period_ns"],
            parts=self._parts if parts is None else parts,
            chunk_rate_hz=self.file["protocol"]["chunk_rate_max_hz"],
            horizon_max=case.horizon_max,
            age_max_ticks=self.file["protocol"]["age_max_ticks"],
            limits=case.overrides,
        )
        self._claims[source] = self.ask("claim", request, ClaimReply)
        return self._claims[source]

    def release(self, source: str = SOURCE, offered_to: str = "") -> None:
        """Give a live claim back, or offer it."""
        claim_id = self._claims[source].claim_id
        self.ask("release", Release(source=source, claim_id=claim_id, offered_to=offered_to), Done)

    def arm_again(self) -> None:
        """Disarm and arm: a new epoch without claims."""
        self.ask("disarm", Disarm(by="test"), Done)
        self.ask("arm", Arm(by="test"), ArmReply)

    def send(self, chunk: Chunk, newest_tick: int, source: str = SOURCE) -> Answer:
        """Send a chunk computed from the newest state; exactly one verdict answers it."""
        self._seq += 1
        message = self.message(chunk, newest_tick, source)
        outputs = self._step("candidate", source, encode(message))
        answers = (decode(Verdict, out.payload) for out in outputs if out.kind == "verdict")
        (verdict,) = (one for one in answers if one.source == source)
        chunks = [decode(SafeChunk, out.payload) for out in outputs if out.kind == "safe_chunk"]
        # What another claim still has to execute may be cut short by what this one will do.
        safe = [one for one in chunks if one.source == source]
        assert len(safe) <= 1
        first = safe[0] if safe else None
        return Answer(verdict, first, self._has_stopped(outputs), message, outputs)

    def message(self, chunk: Chunk, newest_tick: int, source: str = SOURCE) -> ActionChunk:
        """The chunk on the wire, with the next sequence number of the source's live claim."""
        return ActionChunk(
            robot_hash=self._hash,
            session=self._session,
            epoch=self._claims[source].epoch,
            claim_id=self._claims[source].claim_id,
            source=source,
            seq=self._seq,
            goal_id=1,
            obs_tick=newest_tick,
            oldest_tick=newest_tick,
            start_tick=chunk.start_tick,
            horizon=chunk.horizon,
            parts=tuple(
                ActionPart(
                    part=rows.part,
                    mode=rows.mode,
                    frame_id=rows.frame,
                    values=pack_floats(rows.values),
                    active=rows.active,
                )
                for rows in chunk.parts
            ),
            trace=NO_TRACE,
        )

    def state(self, measured: Measured, acted: tuple[Acted, ...] | None = None) -> bool:
        """As `state_reply`; whether the gate stopped."""
        return self.state_reply(measured, acted).stopped

    def state_reply(
        self,
        measured: Measured,
        acted: tuple[Acted, ...] | None = None,
        after_ns: int | None = None,
    ) -> CoreReply:
        """Publish a state, by default one period after the last, just after the heartbeats."""
        beats = self._beats(after_ns)
        message = JointState(
            session=self._session,
            tick=measured.tick,
            episode_tick=1,
            stamp_ns=0,
            positions=pack_floats(measured.positions),
            velocities=pack_floats(measured.velocities),
            efforts=pack_floats(measured.efforts),
            acted=acted or (HELD,) * len(self._parts),
            robot_hash=self._hash,
        )
        return self._reply([*beats, *self._step("joint_state", "", encode(message))])

    def pass_time(self) -> CoreReply:
        """A period in which no state comes."""
        return self._reply([*self._beats(None), *self._step("timer", "", b"")])

    def _beats(self, after_ns: int | None) -> list[GateOutput]:
        self._now_ns += int(self.file["period_ns"]) if after_ns is None else after_ns
        beats = ((s, encode(Heartbeat(claim_id=c.claim_id))) for s, c in self._claims.items())
        return [out for source, beat in beats for out in self._step("heartbeat", source, beat)]

    def send_bytes(self, frame: bytes, key_source: str = SOURCE) -> CoreReply:
        """Put any bytes on the key for chunks of that source."""
        return self._reply(self._step("candidate", key_source, frame))

    def _reply(self, outputs: list[GateOutput]) -> CoreReply:
        verdicts = [decode(Verdict, out.payload) for out in outputs if out.kind == "verdict"]
        stopped = self._has_stopped(outputs)
        self.has_stopped = self.has_stopped or stopped
        safe = [decode(SafeChunk, out.payload) for out in outputs if out.kind == "safe_chunk"]
        return CoreReply(verdicts, stopped, safe, outputs)

    def ask(self, kind: EventKind, request: Message, reply: type[M]) -> M:
        """Put a query, now.

        Raises:
            CaseRefusedError: with the gate's reason.
        """
        outputs = self._step(kind, "", encode(request))
        for out in outputs:
            if out.kind == "refusal":
                raise CaseRefusedError(decode(Refusal, out.payload).reason)
        (answer,) = [out.payload for out in outputs if out.kind == "reply"]
        return decode(reply, answer)

    def status(self) -> GateStatus:
        """What the gate says of itself."""
        return self.ask("status", StatusQuery(), GateStatus)

    def _step(self, kind: EventKind, source: str, payload: bytes) -> list[GateOutput]:
        return self._gate.step(self._now_ns, kind, source, payload)

    def _has_stopped(self, outputs: list[GateOutput]) -> bool:
        states = [decode(GateStatus, out.payload).state for out in outputs if out.kind == "status"]
        return any(state in (GateState.STOPPED, GateState.LATCHED) for state in states)

    def _status(self, pacing: Pacing, tick: int) -> HalStatus:
        parts = tuple(
            HalPart(name=part["name"], simulator_part="", joints=tuple(part["joints"]), ranges=())
            for part in self.file["parts"]
        )
        return HalStatus(
            session=self._session,
            robot=self.file["robot"],
            robot_hash=self._hash,
            pacing=pacing,
            period_ns=self.file["period_ns"],
            tick=tick,
            episode_tick=1,
            state="ready",
            detail="",
            joints=tuple(joint["name"] for joint in self.file["joints"]),
            passive_joints=tuple(joint["name"] for joint in self.file["passive_joints"]),
            parts=parts,
            simulator_order=(),
            cameras=(),
            has_task=False,
            overruns=0,
        )
