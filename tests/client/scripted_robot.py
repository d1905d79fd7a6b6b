"""A robot on the in-memory transport: its services say what a test has them say."""

from __future__ import annotations

from dataclasses import dataclass, field

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.service_spec import ServiceSpec
from fairlead.errors import RefusedError
from fairlead.messages import (
    NO_HASH,
    ArmReply,
    Cancel,
    Claim,
    ClaimReply,
    Done,
    GateState,
    Goal,
    GoalAccepted,
    GoalFeedback,
    GoalResult,
    Grant,
    Heartbeat,
    JointState,
    Lease,
    Message,
    Release,
    StopLevel,
    Transform,
    TransformBatch,
    decode,
    pack_floats,
)
from fairlead.wire.bus import Answer, Qos, Sample, Undeclare
from fairlead.wire.memory_bus import MemoryBus

GOAL_ID, CLAIM_ID, EPOCH, SESSION = 7, 11, 3, 5
DEPLOYMENT = Deployment.model_validate(
    {
        "robot": "panda_mobile",
        "id": "r",
        "profile": "sim",
        "services": {
            "hal": ServiceSpec(run="hal_sim", listen="tcp/127.0.0.1:1"),
            "safety": ServiceSpec(run="safety", listen="tcp/127.0.0.1:2"),
            "runner": ServiceSpec(run="skill_runner", listen="tcp/127.0.0.1:3"),
        },
    }
)


@dataclass
class ScriptedRobot:
    """Remembers what it was asked and told.

    answers_late: takes goals and claims and answers when told to, by `answer`.
    confirms: ends a goal that is cancelled. lists_stops: a lease lists the stops that come.
    refuses: why no claim is granted.
    """

    answers_late: bool = False
    confirms: bool = True
    lists_stops: bool = True
    refuses: str = ""
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
        bus.serve_later(keys.goal("runner"), "runner", self._on_goal)
        bus.serve(keys.cancel("runner"), "runner", self._on_cancel)
        bus.serve_later(keys.claim("planner"), "safety", self._on_claim)
        bus.serve(keys.release("planner"), "safety", self._on_release)
        bus.subscribe(keys.stop, self._on_stop)
        bus.subscribe(keys.heartbeat("planner"), self._on_heartbeat)

    # --- what it says ---------------------------------------------------------------

    def put(self, key: str, message: Message) -> None:
        self.bus.publisher(key, type(message), Qos.STATUS).put(message)

    def say(self, phase: str, outcome: str = "") -> None:
        """Feedback of the goal, with a result where an outcome is given."""
        result = None
        if outcome:
            result = GoalResult(
                outcome=outcome, decided_by="operator", kind="", detail="",  # type: ignore[arg-type]
                first_tick=1, last_tick=2,
            )  # fmt: skip
        feedback = GoalFeedback(
            source="runner", goal_id=GOAL_ID, skill="s", phase=phase, tick=2, queue_depth=0,
            inferences=1, starved=0, last_refusal="", result=result,
        )  # fmt: skip
        self.put(DEPLOYMENT.keys.feedback("runner"), feedback)

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

    def _on_goal(self, payload: bytes, answer: Answer) -> None:
        self.goals.append(decode(Goal, payload))
        self._reply(answer, GoalAccepted(goal_id=GOAL_ID))

    def _on_cancel(self, payload: bytes) -> Message:
        self.cancelled.append(decode(Cancel, payload).goal_id)
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
