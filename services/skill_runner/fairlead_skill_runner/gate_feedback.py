"""What became of a goal's answers: which rows acted, were refused, have yet to act."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fairlead.messages import Hold, JointState, Outcome, Verdict
from fairlead.policy import Actions, Executed, Judged, Observation, PastAnswer
from fairlead.skill.routes import Route
from fairlead.wire.verdict_text import describe

MAX_TICKS = 32
"""Joint states remembered: a layout is never so much older than the newest of them."""
MAX_VERDICTS = 64
MAX_ANSWERS = 4
"""Of which a policy is told what became of their rows."""


@dataclass
class _Answer:
    """One answer, of which ``horizon`` ticks were proposed.

    first, last: the ticks of its rows that the gate released, 0: none.
    """

    rows: Actions
    horizon: int
    acted: npt.NDArray[np.bool_]
    verdict: Verdict | None = None
    first: int = 0
    last: int = 0


class GateFeedback:
    """Collects joint states and verdicts of one claim.

    Args:
        routes: whose parts are the goal's own.
        periods: control periods for one row of the policy.
    """

    def __init__(self, routes: Sequence[Route], periods: int = 1) -> None:
        self._periods = periods
        self._answers: dict[int, _Answer] = {}  # by the tick of their observation
        self._parts = {route.part_name: route.part for route in routes}
        self._acted: dict[int, JointState] = {}
        self._answer_ticks: dict[int, int] = {}  # by verdict
        self.judged: Judged | None = None

    def on_joints(self, joints: JointState) -> None:
        """Remember what acted in the tick before this one."""
        self._acted[joints.tick] = joints
        if len(self._acted) > MAX_TICKS:
            del self._acted[min(self._acted)]
        for one in self.executed(joints.tick).values():
            answer = self._answers.get(one.answer_tick or 0)
            if answer is not None and one.answer_tick is not None:
                row = (joints.tick - 1 - one.answer_tick) // self._periods
                answer.acted[row : row + 1] = True

    def on_answer(self, tick: int, rows: Actions, horizon: int) -> None:
        """Remember an answer to the observation of ``tick``, as the policy gave it.

        Args:
            horizon: ticks of it that were proposed.
        """
        self._answers[tick] = _Answer(rows, horizon, np.zeros(len(rows), np.bool_))
        if len(self._answers) > MAX_ANSWERS:
            released = (asked for asked, one in self._answers.items() if one.first)
            acting = max(released, default=0)  # its rows may act for long
            del self._answers[min(asked for asked in self._answers if asked != acting)]

    def on_verdict(self, verdict: Verdict, answer_tick: int) -> None:
        """Remember which answer a verdict was on, and what it said."""
        self._answer_ticks[verdict.verdict_id] = answer_tick
        self._follow(verdict, answer_tick)
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

    def _follow(self, verdict: Verdict, answer_tick: int) -> None:
        """Rows that a newer answer replaces will not act any more."""
        judged = self._answers.get(answer_tick)
        if judged is None:
            return
        judged.verdict = verdict
        is_refused = verdict.outcome == Outcome.REFUSED
        judged.first, judged.last = (
            (0, 0) if is_refused else (verdict.released_first, verdict.released_last)
        )
        if judged.first:
            for tick, older in self._answers.items():
                if tick < answer_tick:
                    older.last = min(older.last, judged.first - 1)

    def added_to(self, observation: Observation, delay_ticks: int) -> Observation:
        """The observation, with what became of the answers before it."""
        tick = observation.tick
        return replace(
            observation,
            executed=self.executed(tick),
            judged=self.judged,
            answers=tuple(self._past(asked, tick) for asked in sorted(self._answers)),
            delay_ticks=delay_ticks,
            periods=self._periods,
        )

    def _past(self, asked: int, now_tick: int) -> PastAnswer:
        answer, periods = self._answers[asked], self._periods
        first = asked + np.arange(len(answer.rows)) * periods  # each row's first tick
        is_left = (first + periods - 1 >= max(now_tick, answer.first)) & (first <= answer.last)
        verdict = answer.verdict
        refused = np.zeros(len(first), np.bool_)
        if verdict is not None and verdict.outcome == Outcome.REFUSED:
            refused = ~answer.acted
        elif verdict is not None and verdict.outcome == Outcome.TRUNCATED:
            refused = first > verdict.released_last
        refused &= first < asked + answer.horizon
        return PastAnswer(
            tick=asked,
            rows=answer.rows,
            periods=periods,
            outcome="" if verdict is None else Outcome(verdict.outcome).name.lower(),
            acted=answer.acted.copy(),
            refused=refused,
            to_act=is_left & (answer.last > 0),
        )

    def all_held(self, tick: int) -> bool:
        """Whether every part of the goal held in the tick before ``tick``."""
        executed = self.executed(tick)
        return bool(executed) and all(one.hold for one in executed.values())

    def lacked_row(self, tick: int) -> bool:
        """Whether a part of the goal had no released row in the tick before ``tick``."""
        return any(one.hold == _hold_name(Hold.NO_ROW) for one in self.executed(tick).values())

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
