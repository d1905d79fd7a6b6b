"""``fairlead run`` and ``fairlead cancel``: a goal, or a chain of them, from outside."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError, RefusedError, expected
from fairlead.messages import HalStatus
from fairlead.operate.chain import MOST_GOALS, Chain, ChainGoal, ChainRun, read_chain
from fairlead.operate.client import RobotClient, load_meanwhile
from fairlead.operate.connection import choose_file
from fairlead.operate.goal_hearing import Progress
from fairlead.operate.goal_run import GoalOptions
from fairlead.operate.robot import STALL_TIMEOUT_S
from fairlead.operate.runner_choice import choose_runner
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import Admission
from fairlead.skill.manifest import load_skill
from fairlead_tools.cli.arming import YesOption, armed
from fairlead_tools.cli.console import ProgressLine, echo, ends_like_ctrl_c, print_json
from fairlead_tools.cli.episodes import new_episode
from fairlead_tools.cli.loading import load_first
from fairlead_tools.cli.options import (
    MAX_NUMBER,
    DeploymentOption,
    JsonOption,
    choose_deployment,
    complete_skill,
    example,
)
from fairlead_tools.cli.run_output import goal_hints, print_result
from fairlead_tools.cli.running_deployments import wait_seen, wait_started
from fairlead_tools.cli.skill import installed_skill

DEADLINE_TICKS = 1200
"""Of a goal that a person runs, unless they say another."""
MAX_STALL_S = 86_400.0
WhatArgument = Annotated[
    str,
    typer.Argument(
        metavar="SKILL_OR_CHAIN",
        autocompletion=complete_skill,
        help="a skill that ships or is installed (fairlead skill ls), a folder with rskill.yaml, "
        "or a chain of goals: a file ending in .yaml",
    ),
]
RunnerOption = Annotated[
    str, typer.Option(help="which runner, if several can run it: a service of the deployment")
]
PromptOption = Annotated[str, typer.Option(help="instruction; default: the skill's own")]
DeadlineOption = Annotated[
    int,
    typer.Option(min=0, max=MAX_NUMBER, help="give up after so many control periods; 0: never"),
]
StallOption = Annotated[
    float,
    typer.Option(
        min=0.1, max=MAX_STALL_S, help="give up after so many seconds without a released row"
    ),
]


@example("fairlead run oracle-counter-to-cabinet")
def run_command(
    skill: WhatArgument,
    deployment: DeploymentOption = None,
    seed: Annotated[
        int | None,
        typer.Option(
            min=0, max=MAX_NUMBER, help="simulator: start a new episode of this seed first"
        ),
    ] = None,
    runner: RunnerOption = "",
    prompt: PromptOption = "",
    then: Annotated[
        list[str] | None,
        typer.Option(
            help="another goal once this one has succeeded; repeat for more",
            metavar="SKILL[: PROMPT]",
        ),
    ] = None,
    deadline_ticks: DeadlineOption = DEADLINE_TICKS,
    stall_timeout: StallOption = STALL_TIMEOUT_S,
    yes: YesOption = False,
    as_json: JsonOption = False,
) -> None:
    """Arm if disarmed, run a skill, show its progress, print the result, disarm again.

    It disarms only if it armed, or another run that was without a goal then, and only if no other
    claim is live; else the gate disarms 30 s after the last claim. Ctrl-C cancels the goal, or
    stops the robot if the runner does not confirm that.
    A folder is linked into your skills first.
    With --then the goals run one after the other, until one does not succeed. A chain says itself
    which goal comes after which, and how often one is tried again. Between goals of the same
    parts nothing holds, once the first has succeeded; else the parts hold.
    """
    chain = _chain_of(skill, prompt, then or [], runner, deadline_ticks, stall_timeout)
    for goal in chain.goals:
        load_skill(goal.skill)  # one that does not exist is said first
    file = choose_file(deployment)
    chosen = load_deployment(file)
    wishes = {goal.name: _with_runner(goal.wish(), chosen) for goal in chain.goals}
    robot = load_robot(chosen.robot)
    admissions = [Admission(load_skill(wish.skill), robot) for wish in wishes.values()]
    _require(admissions)  # what cannot run should not arm anything
    wait_started(file, lambda line: echo(line, err=True))
    run = ChainRun(chain)
    with ends_like_ctrl_c(), RobotClient(chosen, by="fairlead run") as client:
        wait_seen(client, file)
        client.wait_gate_follows()
        _require(admissions, client.hal_status())
        if seed is not None:
            new_episode(client, seed)
        told: list[dict[str, Any]] = []
        try:
            with ProgressLine(as_json) as line:
                load_first(client, wishes[chain.goals[0].name], line)
            with armed(client, confirmed=yes):
                progress, runner = _run_all(client, run, wishes, told if as_json else None)
        finally:  # after Ctrl-C, too
            if as_json and told:
                several = _is_chain(skill) or then
                ended = {"chain": skill, "outcome": run.ending, "why": run.why, "goals": told}
                print_json(ended if several else told[0])
        gate = client.gate_status()
    if _is_chain(skill) and not as_json:
        why = f": {run.why}" if run.why else ""
        echo(f"{skill} {run.ending or 'ended'} after {run.begun} goals{why}")
    if run.ending != "succeeded":
        for hint in goal_hints(progress, gate, runner):
            echo(hint, err=True)
        raise typer.Exit(1)


def _is_chain(what: str) -> bool:
    """Whether a person means a file with goals."""
    return what.endswith((".yaml", ".yml"))


def _chain_of(
    what: str,
    prompt: str,
    then: Sequence[str],
    runner: str,
    deadline_ticks: int,
    stall_timeout_s: float,
) -> Chain:
    """The goals of a file, or one of a skill and those after it; folders are linked, from there.

    Raises:
        ConfigError: the file or a skill does not fit, or options are given beside a file.
    """
    if not what:
        raise ConfigError(expected("run", "a skill or a chain's file", repr(what)))
    if Path(what).name == "rskill.yaml":
        raise ConfigError(expected("run", "the skill's folder, without rskill.yaml", repr(what)))
    first = ChainGoal(
        name="1",
        skill=what,
        prompt=prompt,
        runner=runner,
        deadline_ticks=deadline_ticks,
        stall_timeout_s=stall_timeout_s,
    )
    if _is_chain(what):
        if then or first != ChainGoal(name="1", skill=what, deadline_ticks=DEADLINE_TICKS):
            wanted = "prompt, runner, deadline and stall timeout of each goal in the file"
            raise ConfigError(expected(f"chain {what}", wanted, "such options on the command line"))
        chain = read_chain(Path(what))
        folders = [Path(what).parent if "/" in goal.skill else Path() for goal in chain.goals]
        skills = [str(one / goal.skill) for one, goal in zip(folders, chain.goals, strict=True)]
    else:
        if len(then) >= MOST_GOALS:
            most = f"at most {MOST_GOALS - 1} goals after the first"
            raise ConfigError(expected("run: --then", most, len(then)))
        steps = [step.partition(":") for step in then]
        others = [
            first.model_copy(update={"name": f"{number}", "prompt": words.strip()})
            for number, (_, _, words) in enumerate(steps, 2)
        ]
        chain = Chain(goals=(first, *others), most_goals=1 + len(others))
        skills = [what, *(skill.strip() for skill, _, _ in steps)]
    goals = []
    for goal, skill in zip(chain.goals, skills, strict=True):
        try:
            goals.append(goal.model_copy(update={"skill": installed_skill(skill)}))
        except ConfigError as error:
            if len(skills) == 1:
                raise
            raise ConfigError(f"goal {goal.name}: {error}") from None
    return chain.model_copy(update={"goals": tuple(goals)})


def _run_all(
    client: RobotClient,
    run: ChainRun,
    wishes: Mapping[str, GoalOptions],
    told: list[dict[str, Any]] | None,
) -> tuple[Progress, str]:
    """One goal after the other; how the last one went, and which runner had it."""
    while run.current is not None:
        wish, following = wishes[run.current.name], run.following
        then = None if following is None else wishes[following.name]
        progress = _run(client, wish, told, then)
        if progress.result is None:
            break
        run.ended(progress.result)
    return progress, wish.runner


def _with_runner(wish: GoalOptions, deployment: Deployment) -> GoalOptions:
    return dataclasses.replace(wish, runner=choose_runner(deployment, wish.skill, wish.runner))


def _require(admissions: Sequence[Admission], hal: HalStatus | None = None) -> None:
    for admission in admissions:
        admission.require(hal)


def _run(
    client: RobotClient,
    wish: GoalOptions,
    told: list[dict[str, Any]] | None,
    then: GoalOptions | None,
) -> Progress:
    """One goal; its result is printed before anything else is asked, also after Ctrl-C.

    told: where the result goes instead, as a document.
    then: the goal that goes on when this one has succeeded; its policy is loaded meanwhile.
    """
    hand_over_to = "" if then is None else then.runner
    goal = client.run(**dataclasses.asdict(wish) | {"hand_over_to": hand_over_to})
    try:
        with goal, ProgressLine(quiet=told is not None) as line:
            if then is not None:
                load_meanwhile(client, then.skill, then.runner)
            for progress in goal:
                line.show(progress.line())
    finally:
        progress = goal.progress
        if progress.result is not None and told is None:
            print_result(wish.skill, progress.result)
        elif progress.result is not None and told is not None:
            ended = {"result": msgspec.structs.asdict(progress.result)}
            told.append(dataclasses.asdict(progress) | ended)
        elif goal.stopped:
            echo(goal.stopped, err=True)
    return progress


@example("fairlead cancel runner")
def cancel_command(
    runner: Annotated[
        str | None, typer.Argument(help="a runner of the deployment; may be left out if only one")
    ] = None,
    deployment: DeploymentOption = None,
) -> None:
    """End the goal that a runner runs; its parts hold, other runners go on."""
    chosen = choose_deployment(deployment)
    name = _chosen_runner(chosen, runner)
    with RobotClient(chosen, by="fairlead cancel") as client:
        goal = client.goal_feedback(name)
        if not goal.goal_id or goal.result is not None:
            raise RefusedError(name, "no goal is running", "fairlead status")
        reply = client.cancel(name, goal.goal_id)
    echo(f"{name}: {reply.text}")


def _chosen_runner(deployment: Deployment, named: str | None) -> str:
    runners = deployment.runners
    name = named or (runners[0] if len(runners) == 1 else None)
    if name in runners:
        return name
    if named is None:
        raise ConfigError(expected("cancel", "the name of a runner", "none", runners))
    what = expected(f"deployment {deployment.id}", "a runner", repr(named), runners)
    raise ConfigError(
        f"{what}; a claim of another program ends where it was started; fairlead disarm ends all"
    )
