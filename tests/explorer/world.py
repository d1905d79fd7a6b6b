"""HAL, gate and runner in virtual time, joined by one channel whose weather can change."""

from __future__ import annotations

import random
from functools import cache
from typing import TypeVar

from bench.equipment.gate_port import EventKind, GateOutput
from bench.equipment.real_gate import RealGate
from fairlead.hal.core import Pacing
from fairlead.messages import (
    Arm,
    ArmReply,
    Claim,
    ClaimReply,
    Done,
    GateState,
    GateStatus,
    JointState,
    Lease,
    Message,
    Refusal,
    Release,
    Reset,
    SafeChunk,
    StatusQuery,
    StopLevel,
    Verdict,
    decode,
    encode,
)
from fairlead.robot.manifest import RobotManifest, load_robot
from tests.explorer.channel import FAIR, MS, Channel, Schedule, Weather
from tests.explorer.hal_actor import HalActor, Tick
from tests.explorer.runner_actor import HORIZON, RunnerActor

TIMER_NS = 5 * MS
M = TypeVar("M", bound=Message)


@cache
def _robot() -> RobotManifest:
    return load_robot("panda_mobile")


class World:
    """One deployment in virtual time. Queries (the operator's) are never lost."""

    def __init__(self, gate: RealGate, pacing: Pacing, seed: int) -> None:
        self.robot = _robot()
        self.schedule = Schedule()
        self.channel = Channel(self.schedule, random.Random(seed))
        self.gate = gate
        self.pacing = pacing
        self.emitted: dict[int, SafeChunk] = {}
        self.verdicts_of: dict[int, list[int]] = {}  # rising, by claim
        self.hal = HalActor(self.robot, pacing, 900 + seed, self.schedule, self._from_hal)
        self.runner = RunnerActor(self.schedule, pacing == "lockstep", self._from_runner)
        self.hal.start()
        self.runner.start()
        self._timer()

    @property
    def history(self) -> list[Tick]:
        return self.hal.history

    def run_ticks(self, count: int, limit_s: float = 600.0) -> None:
        """Run until the robot has stepped ``count`` more ticks; it must within ``limit_s``."""
        goal = len(self.history) + count
        limit_ns = self.schedule.now_ns + round(limit_s * 1e9)
        reached = self.schedule.run(lambda: len(self.history) >= goal, limit_ns)
        assert reached, f"stuck at tick {self.hal.tick} after {limit_s:g} s"

    def run_for(self, milliseconds: float) -> None:
        self.schedule.run(lambda: False, self.schedule.now_ns + round(milliseconds * MS))

    def rain(self, weather: Weather) -> None:
        self.channel.weather = weather

    def bring_up(self) -> None:
        """What an operator does after anything: fair weather, reset, arm, a new claim."""
        self.rain(FAIR)
        self.run_for(1000)
        for _ in range(20):
            status = self.ask("status", StatusQuery(), GateStatus)
            if status.state == GateState.LATCHED:
                self.tell("reset", Reset(by="operator", id=status.latch_id))
            elif status.state == GateState.STOPPED:
                self.tell("reset", Reset(by="operator", id=status.stop_ids[0]))
            elif status.state == GateState.DISARMED:
                self.ask("arm", Arm(by="operator"), ArmReply)
            elif status.state == GateState.ARMED:
                break
            self.run_for(100)
        self.claim()

    def claim(self) -> None:
        status = self.ask("status", StatusQuery(), GateStatus)
        self.runner.drop_claim()
        for live in status.claims:
            self.tell("release", Release(source=live.source, claim_id=live.claim_id))
        self.runner.take_claim(self._ask_claim(), self.robot.robot_hash)

    def hand_over(self, source: str) -> None:
        """The claim's holder offers it to a source, which takes it: a new one, or itself."""
        former = self.runner.source
        self.runner.go_on_as(source or former)
        [live] = self.ask("status", StatusQuery(), GateStatus).claims
        offer = Release(source=former, claim_id=live.claim_id, offered_to=self.runner.source)
        self.ask("release", offer, Done)
        assert self._ask_claim().claim_id == live.claim_id

    def _ask_claim(self) -> ClaimReply:
        request = Claim(
            source=self.runner.source,
            skill="explorer",
            skill_hash=bytes(range(32)),
            robot_hash=self.robot.robot_hash,
            period_ns=self.robot.tick_period_ns,
            parts=("base",),
            chunk_rate_hz=20.0,
            horizon_max=HORIZON,
            age_max_ticks=10,
            limits=(),
        )
        return self.ask("claim", request, ClaimReply)

    def stop(self, stop_id: int, to_hal: bool = True, to_gate: bool = True) -> None:
        """An operator's stop of one message, lost for good to those that do not get it."""
        message = StopLevel(stop_id=stop_id, by="operator", reason="explored")
        if to_hal:
            self.hal.on_stop(message)
        if to_gate:
            self._to_gate("stop_level", "", encode(message))

    def ask(self, kind: EventKind, request: Message, reply: type[M]) -> M:
        outputs = self._step(kind, "", encode(request))
        refusals = [out.payload for out in outputs if out.kind == "refusal"]
        assert not refusals, f"{kind} was refused: {decode(Refusal, refusals[0])}"
        (answer,) = [out.payload for out in outputs if out.kind == "reply"]
        return decode(reply, answer)

    def tell(self, kind: EventKind, request: Message) -> None:
        self._step(kind, "", encode(request))

    def _timer(self) -> None:
        self._to_gate("timer", "", b"")
        self.schedule.at(self.schedule.now_ns + TIMER_NS, self._timer)

    def _from_hal(self, kind: str, payload: bytes) -> None:
        event: EventKind = kind  # type: ignore[assignment]
        self.channel.send(lambda: self._to_gate(event, "", payload))
        if kind == "joint_state":
            state = decode(JointState, payload)
            self.channel.send(lambda: self.runner.on_state(state))

    def _from_runner(self, kind: str, payload: bytes) -> None:
        event: EventKind = kind  # type: ignore[assignment]
        source = self.runner.source
        self.channel.send(lambda: self._to_gate(event, source, payload))

    def _to_gate(self, kind: EventKind, source: str, payload: bytes) -> None:
        self._step(kind, source, payload)

    def _step(self, kind: EventKind, source: str, payload: bytes) -> list[GateOutput]:
        outputs = self.gate.step(self.schedule.now_ns, kind, source, payload)
        for output in outputs:
            self._route(output)
        return outputs

    def _route(self, output: GateOutput) -> None:
        if output.kind == "lease":
            lease = decode(Lease, output.payload)
            self.channel.send(lambda: self.hal.on_lease(lease))
        elif output.kind == "safe_chunk":
            chunk = decode(SafeChunk, output.payload)
            if chunk.verdict_id not in self.emitted:
                self.verdicts_of.setdefault(chunk.claim_id, []).append(chunk.verdict_id)
            assert self.emitted.setdefault(chunk.verdict_id, chunk) == chunk
            self.channel.send(lambda: self.hal.on_safe_chunk(chunk))
        elif output.kind == "verdict":
            verdict = decode(Verdict, output.payload)
            self.channel.send(lambda: self.runner.on_verdict(output.source, verdict))
