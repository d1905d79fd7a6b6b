"""The runner's world as plain messages: what a HAL, an assembler and a gate would send."""

from __future__ import annotations

from dataclasses import dataclass, field

import msgspec
import numpy as np

from fairlead.messages import (
    HELD,
    NO_HASH,
    Acted,
    ActionChunk,
    GateState,
    Grant,
    Hold,
    JointState,
    LayoutFault,
    LayoutState,
    Lease,
    Outcome,
    TaskState,
    Verdict,
    decode,
    pack_floats,
)
from fairlead.policy import Actions
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner.run_core import RunCore
from fairlead_skill_runner.run_outputs import AskPolicy, Output, SendChunk
from fairlead_skill_runner.run_setup import RunSetup

ROBOT = load_robot("panda_mobile")
SKILL = load_skill("oracle-counter-to-cabinet")
ROUTES = resolve_routes(SKILL.action_contract, ROBOT)
SESSION, EPOCH, CLAIM, GOAL = 11, 22, 33, 44
EXECUTED = Acted(hold=Hold.NONE, verdict_id=1, row=0)
NO_ROW = Acted(hold=Hold.NO_ROW, verdict_id=0, row=0)


def joints(tick: int, *, session: int = SESSION, acted: Acted = HELD) -> JointState:
    n = len(ROBOT.measured_joint_names)
    block = pack_floats(np.zeros(n))
    return JointState(
        session=session, tick=tick, episode_tick=1, stamp_ns=0, positions=block,
        velocities=block, efforts=block, acted=(acted,) * 4, robot_hash=ROBOT.robot_hash,
    )  # fmt: skip


def layout(tick: int, *, session: int = SESSION, oldest: int | None = None) -> LayoutState:
    return LayoutState(
        session=session, tick=tick, episode_tick=1, oldest_tick=tick if oldest is None else oldest,
        skill=SKILL.id, skill_hash=SKILL.skill_hash, layout="mobile_pick_30d",
        values=pack_floats(np.full(30, float(tick))), fault=None,
    )  # fmt: skip


def broken_layout(tick: int) -> LayoutState:
    fault = LayoutFault(
        kind="missing_frame", name="grip_site", parent="base_site", age_ticks=-1,
        text="no transform to grip_site",
    )  # fmt: skip
    return msgspec.structs.replace(layout(tick), values=None, fault=fault)


def task(tick: int, success: bool = False) -> TaskState:
    return TaskState(session=SESSION, tick=tick, episode_tick=1, success=success, metrics=())


def lease(
    seq: int, *, epoch: int = EPOCH, state: GateState = GateState.ARMED, claims: tuple[int, ...]
) -> Lease:
    grants = tuple(
        Grant(source="runner", claim_id=c, until_tick=9, decision=0, verdict_id=0) for c in claims
    )
    return Lease(
        session=SESSION, epoch=epoch, lease_seq=seq, config_hash=NO_HASH, state=state,
        state_tick=1, grants=grants, stop_ids=(),
    )  # fmt: skip


def verdict(
    chunk: ActionChunk,
    verdict_id: int,
    outcome: Outcome = Outcome.RELEASED,
    first: int = 0,
    last: int = 0,
) -> Verdict:
    refused = outcome == Outcome.REFUSED
    bad = outcome != Outcome.RELEASED
    return Verdict(
        verdict_id=verdict_id, session=SESSION, epoch=EPOCH, claim_id=chunk.claim_id,
        source="runner", seq=chunk.seq, outcome=outcome, code=20 if bad else 0,
        row=2 if bad else -1, part="arm" if bad else "", axis="linear" if bad else "",
        value=5.0 if bad else 0.0, limit=0.0867 if bad else 0.0, margin=-4.9 if bad else 0.0,
        limit_source="robot.yaml" if bad else "",
        released_first=0 if refused else first or chunk.start_tick,
        released_last=0 if refused else last or chunk.start_tick + chunk.horizon - 1,
        config_hash=NO_HASH, latency_ns=1000,
    )  # fmt: skip


def setup(
    *,
    lockstep: bool,
    deadline_ticks: int = 0,
    stall_timeout_s: float = 5.0,
    skill: SkillManifest = SKILL,
    camera_periods: dict[str, int] | None = None,
    periods: int = 1,
    handed_over: bool = False,
) -> RunSetup:
    return RunSetup(
        source="runner", goal_id=GOAL, skill=skill, routes=ROUTES, prompt="pick",
        deadline_ticks=deadline_ticks, stall_timeout_s=stall_timeout_s, session=SESSION,
        robot_hash=ROBOT.robot_hash, lockstep=lockstep, has_task=True, claim_id=CLAIM,
        epoch=EPOCH, n_dof=ROBOT.n_dof, camera_periods=camera_periods or {}, periods=periods,
        handed_over=handed_over,
    )  # fmt: skip


def rows(horizon: int = 8, value: float = 0.1) -> Actions:
    return np.full((horizon, 12), value, dtype=np.float32)


@dataclass
class Story:
    """A core and everything it put out; time stands still unless told."""

    core: RunCore
    now_s: float = 0.0
    asked: list[AskPolicy] = field(default_factory=list)
    sent: list[bytes] = field(default_factory=list)
    verdicts: int = 0

    def take(self, outputs: list[Output]) -> None:
        for output in outputs:
            if isinstance(output, SendChunk):
                self.sent.append(output.payload)
            else:
                self.asked.append(output)

    @property
    def chunk(self) -> ActionChunk:
        return decode(ActionChunk, self.sent[-1])

    def tick(self, tick: int, *, success: bool = False, acted: Acted = HELD) -> None:
        """What the HAL and the assembler send for one tick."""
        self.take(self.core.on_task(task(tick, success), self.now_s))
        self.take(self.core.on_joints(joints(tick, acted=acted), self.now_s))
        seen = msgspec.structs.replace(layout(tick), skill_hash=self.core.setup.skill.skill_hash)
        self.take(self.core.on_layout(seen, self.now_s))

    def answer(self, actions: Actions | None = None) -> None:
        call = self.asked[-1].call
        self.take(self.core.on_policy(call, rows() if actions is None else actions, self.now_s))

    def judge(self, outcome: Outcome = Outcome.RELEASED, first: int = 0, last: int = 0) -> None:
        self.verdicts += 1
        judged = verdict(self.chunk, self.verdicts, outcome, first, last)
        self.take(self.core.on_verdict(judged, self.now_s))

    def seen_ticks(self) -> list[int]:
        return [question.observation.tick for question in self.asked]


def story(*, lockstep: bool, **changes: object) -> Story:
    return Story(RunCore(setup(lockstep=lockstep, **changes), 0.0))  # type: ignore[arg-type]
