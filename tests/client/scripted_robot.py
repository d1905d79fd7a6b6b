"""A robot on the in-memory transport: its services say what a test has them say."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field

from fairlead import RunningGoal
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.service_spec import ServiceSpec
from fairlead.errors import RefusedError
from fairlead.messages import (
    NO_HASH,
    ArmReply,
    Cancel,
    Claim,
    ClaimInfo,
    ClaimReply,
    Done,
    GateState,
    GateStatus,
    Goal,
    GoalAccepted,
    GoalFeedback,
    GoalResult,
    Grant,
    HalPart,
    HalStatus,
    Heartbeat,
    JointState,
    Lease,
    Message,
    ModeRange,
    Outcome,
    Release,
    StopLevel,
    Transform,
    TransformBatch,
    Verdict,
    decode,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Answer, Qos, Sample, Undeclare
from fairlead.wire.memory_bus import MemoryBus
from tests.client.turns import turns

GOAL_ID, CLAIM_ID, EPOCH, SESSION = 7, 11, 3, 5
DEPLOYMENT = Deployment.model_validate(
    {
        "robot": "panda_mobile",
        "id": "r",
        "profile": "sim",
        "services": {
            "hal": ServiceSpec(run="hal_sim"),
            "safety": ServiceSpec(run="safety"),
            "runner": ServiceSpec(run="skill_runner"),
        },
    }
)


@dataclass
class ScriptedRobot:
    """Remembers what it was asked and told.

    answers_late: takes goals and claims and answers when told to, by `answer`.
    confirms: ends a goal that is cancelled. lists_stops: a lease lists the stops that come.
    forgot: the runner began anew and knows of no goal.
    refuses: why no claim is granted. granted: sources that hold one, as the gate's status has it.
    """

    answers_late: bool = False
    confirms: bool = True
    lists_stops: bool = True
    forgot: bool = False
    refuses: str = ""
    granted: list[str] = field(default_factory=list)
    bus: MemoryBus = field(default_factory=MemoryBus)
    goals: list[Goal] = field(default_factory=list)
    cancelled: list[int] = field(default_factory=list)
    stops: list[StopLevel] = field(default_factory=list)
    claims: list[Claim] = field(default_factory=list)
    released: list[int] = field(default_factory=list)
    beats: int = 0
    tokens: dict[str, Undeclare] = field(default_factory=dict)
    waiting: list[tuple[Answer, Message]] = field(default_factory=list)
    seq: int = 0

    def __post_init__(self) -> None:
        bus, keys = self.bus, DEPLOYMENT.keys
        for service in DEPLOYMENT.services:
            self.tokens[service] = bus.declare_token(keys.alive(service))
        bus.serve(keys.gate_command("arm"), "safety", lambda _: ArmReply(epoch=EPOCH, session=1))
        self.gate = bus.serve(keys.gate_status, "safety", lambda _: self._gate_status())
        bus.serve(keys.hal_status, "hal", lambda _: hal_status())
        bus.serve_later(keys.goal("runner"), "runner", self._on_goal)
        bus.serve(keys.feedback("runner"), "runner", lambda _: _feedback(0, "", None))
        bus.serve(keys.cancel("runner"), "runner", self._on_cancel)
        bus.serve_later(keys.claim("planner"), "safety", self._on_claim)
        bus.serve(keys.release("planner"), "safety", self._on_release)
        bus.subscribe(keys.stop, self._on_stop)
        bus.subscribe(keys.heartbeat("planner"), self._on_heartbeat)

    # --- what it says ---------------------------------------------------------------

    def put(self, key: str, message: Message) -> None:
        self.bus.publisher(key, type(message), Qos.STATUS).put(message)

    def say(self, phase: str, outcome: str = "", goal_id: int = GOAL_ID) -> None:
        """Feedback of a goal, with a result where an outcome is given."""
        result = None
        if outcome:
            result = GoalResult(
                outcome=outcome, decided_by="operator", kind="", detail="",  # type: ignore[arg-type]
                first_tick=1, last_tick=2,
            )  # fmt: skip
        self.put(DEPLOYMENT.keys.feedback("runner"), _feedback(goal_id, phase, result))

    def lease(self, *, granted: bool = True, state: GateState = GateState.ARMED) -> None:
        """The next lease, with or without the claim."""
        self.seq += 1
        grant = Grant(source="planner", claim_id=CLAIM_ID, until_tick=9, decision=0, verdict_id=0)
        lease = Lease(
            session=SESSION, epoch=EPOCH, lease_seq=self.seq, config_hash=NO_HASH, state=state,
            state_tick=1, grants=(grant,) if granted else (),
            stop_ids=tuple(stop.stop_id for stop in self.stops),
        )  # fmt: skip
        self.put(DEPLOYMENT.keys.lease, lease)

    def verdict(self, seq: int, outcome: int = Outcome.RELEASED) -> None:
        """The gate's answer to a chunk of the runner."""
        verdict = Verdict(
            verdict_id=seq, session=SESSION, epoch=EPOCH, claim_id=CLAIM_ID, source="runner",
            seq=seq, outcome=outcome, code=0, row=-1, part="", axis="", value=0.0, limit=0.0,
            margin=0.0, limit_source="", released_first=1, released_last=2,
            config_hash=NO_HASH, latency_ns=1,
        )  # fmt: skip
        self.put(DEPLOYMENT.keys.verdict("runner"), verdict)

    def joints(self, tick: int) -> None:
        state = JointState(
            session=SESSION, tick=tick, episode_tick=1, stamp_ns=0, positions=b"",
            velocities=b"", efforts=b"", acted=(), robot_hash=NO_HASH,
        )  # fmt: skip
        self.put(DEPLOYMENT.keys.joints, state)

    def transforms(self, tick: int, x_m: float, *, static: bool = False) -> None:
        """Where the base is, or what never moves."""
        pose = Transform(
            parent="base_link" if static else "odom",
            child="camera" if static else "base_link",
            translation=pack_floats([x_m, 0.0, 0.0]),
            rotation_xyzw=pack_floats([0.0, 0.0, 0.0, 1.0]),
        )
        batch = TransformBatch(session=SESSION, tick=tick, is_static=static, transforms=(pose,))
        self.put(DEPLOYMENT.keys.tf("hal"), batch)

    def answer(self) -> None:
        """Answer what has waited longest."""
        answer, message = self.waiting.pop(0)
        answer(message)

    # --- what it is asked -----------------------------------------------------------

    def _reply(self, answer: Answer, message: Message) -> None:
        if self.answers_late:
            self.waiting.append((answer, message))
        else:
            answer(message)

    def _gate_status(self) -> GateStatus:
        claims = tuple(
            ClaimInfo(source=source, skill="s", claim_id=CLAIM_ID, parts=())
            for source in self.granted
        )
        return GateStatus(
            robot="r", profile="sim", session=SESSION, epoch=EPOCH, state=GateState.ARMED,
            cause="", fix="", latch_id=0, stop_ids=(), claims=claims, counters=(), state_tick=1,
            lockstep_allowed=True, config_hash=NO_HASH, robot_hash=NO_HASH,
        )  # fmt: skip

    def _on_goal(self, payload: bytes, answer: Answer) -> None:
        self.goals.append(decode(Goal, payload))
        self._reply(answer, GoalAccepted(goal_id=GOAL_ID))

    def _on_cancel(self, payload: bytes) -> Message:
        self.cancelled.append(decode(Cancel, payload).goal_id)
        if self.forgot:
            raise RefusedError("runner", "no such goal is running")
        if self.confirms:
            self.say("ended", "cancelled")
        return Done(text="cancelled")

    def _on_claim(self, payload: bytes, answer: Answer) -> None:
        claim = decode(Claim, payload)
        if self.refuses:
            raise RefusedError("safety", self.refuses)
        self.claims.append(claim)
        self._reply(answer, ClaimReply(claim_id=CLAIM_ID, epoch=EPOCH, session=SESSION))

    def _on_release(self, payload: bytes) -> Message:
        self.released.append(decode(Release, payload).claim_id)
        return Done(text="")

    def _on_stop(self, sample: Sample) -> None:
        self.stops.append(decode(StopLevel, sample.payload))
        if self.lists_stops:
            self.lease(state=GateState.STOPPED)

    def _on_heartbeat(self, sample: Sample) -> None:
        assert decode(Heartbeat, sample.payload).claim_id == CLAIM_ID
        self.beats += 1


def _feedback(goal_id: int, phase: str, result: GoalResult | None) -> GoalFeedback:
    return GoalFeedback(
        source="runner", goal_id=goal_id, skill="s", phase=phase, tick=2, queue_depth=0,
        inferences=1, starved=0, last_refusal="", result=result,
    )  # fmt: skip


async def waiting_for(goal: RunningGoal) -> asyncio.Task[GoalResult]:
    """A task that waits for the result, and does so already."""
    task = asyncio.ensure_future(goal.result())
    await turns()
    return task


def hal_status() -> HalStatus:
    """Of a HAL that has no composite switch."""
    robot = load_robot(DEPLOYMENT.robot)
    return HalStatus(
        session=SESSION, robot=robot.id, robot_hash=robot.robot_hash, pacing="realtime",
        period_ns=robot.tick_period_ns, tick=1, episode_tick=1, state="ready", detail="",
        joints=robot.joint_names, passive_joints=robot.passive_joint_names,
        parts=tuple(
            HalPart(
                name=part.name, simulator_part="", joints=part.joints,
                ranges=tuple(
                    ModeRange(mode=int(mode), lower=b"", upper=b"")
                    for mode in part.control_modes if mode is not ControlMode.COMPOSITE_MODE
                ),
            )
            for part in robot.parts
        ),
        simulator_order=(), cameras=(), has_task=True, overruns=0,
    )  # fmt: skip
