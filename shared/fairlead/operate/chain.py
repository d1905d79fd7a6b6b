"""A chain of goals in a file: which comes after which, by how each ended."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fairlead.messages import GoalResult
from fairlead.operate.failure_kinds import FAILURE_KINDS
from fairlead.operate.goal_run import GoalOptions
from fairlead.operate.robot import STALL_TIMEOUT_S
from fairlead.policy import FAILURE_KIND
from fairlead.yaml_file import load_yaml

NEXT, DONE, FAIL, ANY = "next", "done", "fail", "any"
RESERVED = (NEXT, DONE, FAIL, ANY)
ENDING = ("cancelled", "claim_lost")
"""Kinds that end a chain: somebody stopped the robot, or took its parts."""

MOST_GOALS = 1000
"""That a chain may run."""

Ending = Literal["", "succeeded", "failed"]


class ChainGoal(BaseModel):
    """One goal.

    Attributes:
        name: what other goals call it; no other has it.
        skill: a known skill's id, or a folder, from where the file is.
        prompt, runner, stall_timeout_s: as `GoalOptions`.
        deadline_ticks: it has failed (kind ``deadline``) after so many control periods;
            0: never.
        retries: how often it is begun again after a failure that `on_failure` does not name.
        on_success: a goal's name, ``next`` or ``done``; the last goal's ``next`` is ``done``.
        on_failure: by kind, or ``any`` for all others: a goal's name, or ``fail``.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$")
    skill: str = Field(min_length=1)
    prompt: str = ""
    runner: str = ""
    deadline_ticks: int = Field(ge=0, lt=2**64)
    stall_timeout_s: float = Field(default=STALL_TIMEOUT_S, gt=0, allow_inf_nan=False)
    retries: int = Field(default=0, ge=0, le=100)
    on_success: str = NEXT
    on_failure: dict[str, str] = Field(default_factory=dict)

    def wish(self) -> GoalOptions:
        """What to ask a runner for."""
        return GoalOptions(
            self.skill, self.prompt, self.deadline_ticks, self.stall_timeout_s, self.runner
        )


class Chain(BaseModel):
    """Goals in the order of the file; the first one begins.

    most_goals: how many are run at most, retries counted: no chain goes on for ever.
    own_kinds: of failures, that the goals' policies say and no other goal's.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    goals: tuple[ChainGoal, ...] = Field(min_length=1)
    most_goals: int = Field(ge=1, le=MOST_GOALS)
    own_kinds: tuple[Annotated[str, Field(pattern=f"^{FAILURE_KIND}$")], ...] = ()

    @model_validator(mode="after")
    def _check_names(self) -> Self:
        names = [goal.name for goal in self.goals]
        for name in names:
            if names.count(name) > 1 or name in RESERVED:
                raise ValueError(
                    f"goals: expected names of their own, none of {', '.join(RESERVED)}; "
                    f"got {name!r}"
                )
        for goal in self.goals:
            _check_target(f"goal {goal.name!r}: on_success", goal.on_success, [NEXT, DONE, *names])
            for kind, target in goal.on_failure.items():
                if kind in ENDING:
                    raise ValueError(f"goal {goal.name!r}: on_failure: {kind} ends the whole chain")
                _check_kind(f"goal {goal.name!r}: on_failure", kind, self.own_kinds)
                _check_target(f"goal {goal.name!r}: on_failure: {kind}", target, [FAIL, *names])
        return self


def _check_target(who: str, target: str, valid: list[str]) -> None:
    if target not in valid:
        raise ValueError(f"{who}: expected one of {', '.join(valid)}, got {target!r}")


def _check_kind(who: str, kind: str, own: tuple[str, ...]) -> None:
    valid = [ANY, *own, *(one for one in FAILURE_KINDS if one not in ENDING)]
    if kind not in valid:
        close = difflib.get_close_matches(kind, valid, n=1)
        meant = f" (did you mean {close[0]}?)" if close else ""
        raise ValueError(
            f"{who}: expected one of {', '.join(valid)}, got {kind!r}{meant}; one that a policy of "
            "yours says goes into own_kinds of the chain"
        )


def read_chain(file: Path) -> Chain:
    """Read and check a chain.

    Raises:
        ConfigError: naming the file and every field that does not fit.
    """
    return load_yaml(file, Chain)


class ChainRun:
    """Where a chain stands.

    Attributes:
        current: the goal that runs, or is the next to; None once it has ended.
        ending: how it ended; "" before.
        why: of a chain that failed, in words.
        begun: goals that have ended, retries counted.
    """

    def __init__(self, chain: Chain) -> None:
        self._chain, self._tries = chain, 0
        self._names = [goal.name for goal in chain.goals]
        self.current: ChainGoal | None = chain.goals[0]
        self.ending: Ending = ""
        self.why = ""
        self.begun = 0

    @property
    def following(self) -> ChainGoal | None:
        """The goal that begins if the current one succeeds."""
        if self.current is None or self.begun + 1 >= self._chain.most_goals:
            return None
        name = self._after_success(self.current)
        return None if name == DONE else self._chain.goals[self._names.index(name)]

    def ended(self, result: GoalResult) -> None:
        """Go on from how the current goal ended."""
        goal = self.current
        assert goal is not None
        self.begun += 1
        self._tries += result.kind not in goal.on_failure
        target = self._target(goal, result)
        if target in (DONE, FAIL):
            self.current = None
            self.ending = "succeeded" if target == DONE else "failed"
            self.why = "" if target == DONE else f"{goal.name}: {result.kind}: {result.detail}"
        elif self.begun >= self._chain.most_goals:
            self.current, self.ending = None, "failed"
            self.why = f"most_goals: {self.begun} goals have run, and {target} would be the next"
        elif target != goal.name or result.outcome == "succeeded":
            self.current, self._tries = self._chain.goals[self._names.index(target)], 0

    def _target(self, goal: ChainGoal, result: GoalResult) -> str:
        if result.outcome == "succeeded":
            return self._after_success(goal)
        if result.outcome == "cancelled" or result.kind in ENDING:
            return FAIL
        if result.kind in goal.on_failure:
            return goal.on_failure[result.kind]
        return goal.name if self._tries <= goal.retries else goal.on_failure.get(ANY, FAIL)

    def _after_success(self, goal: ChainGoal) -> str:
        if goal.on_success != NEXT:
            return goal.on_success
        following = self._names.index(goal.name) + 1
        return self._names[following] if following < len(self._names) else DONE
