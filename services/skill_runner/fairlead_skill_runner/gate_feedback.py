"""What became of a goal's answers: which row acted in which tick, what the gate said last."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from fairlead.messages import Hold, JointState, Outcome, Verdict
from fairlead.policy import Executed, Judged, Observation
from fairlead.skill.routes import Route
from fairlead.wire.verdict_text import describe

MAX_TICKS = 32
"""Joint states remembered: a layout is never so much older than the newest of them."""
MAX_VERDICTS = 64


class GateFeedback:
    """Collects joint states and verdicts of one claim.

    Args:
        routes: whose parts are the goal's own.
    """

    def __init__(self, routes: Sequence[Route]) -> None:
        self._parts = {route.part_name: route.part for route in routes}
        self._acted: dict[int, JointState] = {}
        self._answer_ticks: dict[int, int] = {}  # by verdict
        self.judged: Judged | None = None

    def on_joints(self, joints: JointState) -> None:
        """Remember what acted in the tick before this one."""
        self._acted[joints.tick] = joints
        if len(self._acted) > MAX_TICKS:
            del self._acted[min(self._acted)]

    def on_verdict(self, verdict: Verdict, answer_tick: int) -> None:
        """Remember which answer a verdict was on, and what it said."""
        self._answer_ticks[verdict.verdict_id] = answer_tick
        if len(self._answer_ticks) > MAX_VERDICTS:
            del self._answer_ticks[min(self._answer_ticks)]
        refused, whole = Outcome.REFUSED, verdict.outcome == Outcome.RELEASED
        self.judged = Judged(
            answer_tick=answer_tick,
            outcome=Outcome(verdict.outcome).name.lower(),
            code="" if whole else f"G{verdict.code:03d}",
            text="" if whole else describe(verdict),
            last_tick=0 if verdict.outcome == refused else verdict.released_last,
        )

    def added_to(self, observation: Observation) -> Observation:
        """The observation, with what became of the answers before it."""
        return replace(observation, executed=self.executed(observation.tick), judged=self.judged)

    def all_held(self, tick: int) -> bool:
        """Whether every part of the goal held in the tick before ``tick``."""
        executed = self.executed(tick)
        return bool(executed) and all(one.hold for one in executed.values())

    def executed(self, tick: int) -> Mapping[str, Executed]:
        """Per part, what it did in the tick before ``tick``; empty if no state told."""
        joints = self._acted.get(tick)
        if joints is None:
            return {}
        return {
            name: Executed(
                _hold_name(joints.acted[part].hold),
                self._answer_ticks.get(joints.acted[part].verdict_id),
            )
            for name, part in self._parts.items()
            if part < len(joints.acted)
        }


def _hold_name(hold: int) -> str:
    if hold == Hold.NONE:
        return ""
    return Hold(hold).name.lower() if hold in set(Hold) else f"hold {hold}"
