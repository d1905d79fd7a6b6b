"""Every way a goal can end, with its typed kind and its words."""

from __future__ import annotations

from typing import Literal

import msgspec

from fairlead.errors import (
    ConfigError,
    FairleadError,
    NoAnswerError,
    PolicyError,
    RefusedError,
)
from fairlead.messages import GoalResult, LayoutFault, LayoutState
from fairlead.operate.failure_kinds import OfRunner
from fairlead.policy import Done, Failed
from fairlead.skill.manifest import SkillManifest

Ending = Literal["succeeded", "failed", "cancelled", "deadline"]
Decider = Literal["task", "policy", "operator", "runner"]


def _ended(outcome: Ending, by: Decider, kind: str, detail: str) -> GoalResult:
    return GoalResult(
        outcome=outcome, decided_by=by, kind=kind, detail=detail, first_tick=0, last_tick=0
    )


def _failed(kind: OfRunner, detail: str, by: Decider = "runner") -> GoalResult:
    return _ended("failed", by, kind, detail)


def at_ticks(result: GoalResult, first_tick: int, last_tick: int, note: str) -> GoalResult:
    """The same result with the goal's first observation and its newest tick.

    note: what else is to be said in its words; may be empty.
    """
    detail = f"{result.detail}; {note}" if note else result.detail
    return msgspec.structs.replace(
        result, first_tick=first_tick, last_tick=last_tick, detail=detail
    )


def success() -> GoalResult:
    """The task is done, as the simulator checks it."""
    return _ended("succeeded", "task", "", "the task's own check says so")


def solved_before() -> GoalResult:
    """The task was done before the skill's first row: that is no success of the skill."""
    return _failed(
        "already_solved",
        "the task's own check was true before the skill did anything; for a new scene: "
        "fairlead run with --seed",
        by="task",
    )


def deadline(ticks: int, refused: str = "") -> GoalResult:
    """The goal had ``ticks`` ticks after its first observation, and they are over."""
    why = f"; {refused}" if refused else ""
    return _ended("deadline", "runner", "deadline", f"not done after {ticks} ticks{why}")


def cancelled(by: str) -> GoalResult:
    """``by`` asked for the end."""
    return _ended("cancelled", "operator", "cancelled", f"cancelled by {by}")


def policy_error(error: FairleadError) -> GoalResult:
    """The policy failed, hung, or returned something that is no action."""
    return _failed("policy_error", str(error), by="policy")


def by_policy(end: Done | Failed) -> GoalResult:
    """The policy itself says that the goal is reached, or why it cannot be."""
    if isinstance(end, Done):
        return _ended("succeeded", "policy", "", end.reason)
    return _ended("failed", "policy", end.kind, end.reason)


def of_error(error: FairleadError) -> GoalResult:
    """A goal that ended before its first tick."""
    if isinstance(error, PolicyError):
        return policy_error(error)
    kinds: dict[type[FairleadError], OfRunner] = {
        RefusedError: "claim_refused",
        NoAnswerError: "no_answer",
        ConfigError: "not_admitted",
    }
    return _failed(kinds.get(type(error), "error"), str(error))


def claim_lost(words: str) -> GoalResult:
    """The gate does not grant the claim any more; ``words`` say how that was seen."""
    return _failed("claim_lost", words)


def gate_left(what: str, why: str = "") -> GoalResult:
    """Before the goal had a claim the gate stopped, latched, disarmed or started anew."""
    because = f" ({why})" if why else ""
    return claim_lost(f"no claim was taken: {what}{because}; give the goal again")


def new_session(ours: int, theirs: int) -> GoalResult:
    """The HAL was restarted: ticks and claims of the old session mean nothing."""
    return _failed(
        "new_session", f"the HAL started anew: session {theirs:016x}, the claim's was {ours:016x}"
    )


def hal_fault(detail: str) -> GoalResult:
    """The backend failed; the robot holds until its HAL is started again."""
    return _failed("hal_fault", f"the HAL reports a fault: {detail}")


def stalled(quiet_s: float, awaited: str, tick: int, last_refusal: str) -> GoalResult:
    """Nothing was released for ``quiet_s``; says what was awaited and refused last."""
    refusal = f"; last refusal: {last_refusal}" if last_refusal else ""
    where = f"waiting for {awaited} at tick {tick}"
    return _failed("stalled", f"no rows released for {quiet_s:.1f} s, {where}{refusal}")


def layout_fault(tick: int, fault: LayoutFault) -> GoalResult:
    """The assembler's own reason, as ``layout_<kind>``."""
    parent = f" in {fault.parent}" if fault.parent else ""
    age = f", newest {fault.age_ticks} ticks old" if fault.age_ticks >= 0 else ", never seen"
    told = f"at tick {tick}: {fault.name}{parent}{age}: {fault.text}"
    return _ended("failed", "runner", f"layout_{fault.kind}", told)


def layout_missing(silent_ticks: int, tick: int) -> GoalResult:
    """The assembler has died, hangs, or cannot be reached."""
    return _failed(
        "layout_missing",
        f"no layout from the state_assembler for {silent_ticks} ticks, at tick {tick}",
    )


def camera_lost(words: str) -> GoalResult:
    """A camera stalls, repeats one exposure, or shows nothing any more."""
    return _failed("camera_lost", words)


def wrong_layout(skill: SkillManifest, layout: LayoutState) -> GoalResult | None:
    """A layout that is not what the skill declares ends the goal; None if it is."""
    contract = skill.state_contract
    pairs: list[tuple[str, object, object]] = [
        ("layout", contract.layout_name, layout.layout),
        ("skill hash", skill.skill_hash.hex()[:16], layout.skill_hash.hex()[:16]),
    ]
    if layout.values is not None:
        pairs.append(("width", contract.dim, len(layout.values) / 8))
    for what, wanted, got in pairs:
        if wanted != got:
            detail = f"state_assembler sends {what} {got}, skill {skill.id} needs {wanted}"
            return _failed("layout_mismatch", detail)
    return None


def internal_error(error: Exception) -> GoalResult:
    """A bug in the runner: it stops rather than goes on."""
    return _failed("internal_error", f"{type(error).__name__}: {error}")
