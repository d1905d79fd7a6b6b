"""The goals of one ``fairlead run``: of a file, or a skill and those after it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fairlead.errors import ConfigError, expected
from fairlead.operate.chain import Chain, ChainGoal, ChainRun, read_chain
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.skill import installed_skill

DEADLINE_TICKS = 1200
"""Of a goal that a person runs, unless they say another."""


def is_chain(what: str) -> bool:
    """Whether a person means a file with goals."""
    return what.endswith((".yaml", ".yml"))


def chain_of(
    what: str,
    prompt: str,
    then: Sequence[str],
    runner: str,
    deadline_ticks: int,
    stall_timeout_s: float,
) -> Chain:
    """The goals of a file, or one of a skill and those after it; folders are linked.

    Raises:
        ConfigError: the file or a skill does not fit, or options are given beside a file.
    """
    if not what:
        raise ConfigError(expected("run", "a skill or a chain's file", repr(what)))
    first = ChainGoal(
        name="1",
        skill=what,
        prompt=prompt,
        runner=runner,
        deadline_ticks=deadline_ticks,
        stall_timeout_s=stall_timeout_s,
    )
    if is_chain(what):
        if then or first != ChainGoal(name="1", skill=what, deadline_ticks=DEADLINE_TICKS):
            wanted = "prompt, runner, deadline and stall timeout of each goal in the file"
            raise ConfigError(expected(f"chain {what}", wanted, "such options on the command line"))
        chain = read_chain(Path(what))
        skills = [_from(Path(what).parent, goal.skill) for goal in chain.goals]
    else:
        steps = [step.partition(":") for step in then]
        others = [
            first.model_copy(update={"name": f"{number}", "prompt": words.strip()})
            for number, (_, _, words) in enumerate(steps, 2)
        ]
        chain = Chain(goals=(first, *others), most_goals=1 + len(others))
        skills = [what, *(skill.strip() for skill, _, _ in steps)]
    goals = [
        goal.model_copy(update={"skill": installed_skill(skill)})
        for goal, skill in zip(chain.goals, skills, strict=True)
    ]
    return chain.model_copy(update={"goals": tuple(goals)})


def _from(folder: Path, skill: str) -> str:
    """A folder's path is from where the chain's file is."""
    return str(folder / skill) if "/" in skill else skill


def ending_document(what: str, run: ChainRun, goals: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """How several goals ended, and each of them, in the order in which they ran."""
    return {"chain": what, "outcome": run.ending, "why": run.why, "goals": list(goals)}


def print_ending(file: str, run: ChainRun) -> None:
    """How a chain from a file ended."""
    why = f": {run.why}" if run.why else ""
    echo(f"{file} {run.ending or 'ended'} after {run.begun} goals{why}")
