"""``fairlead eval SKILL``: one goal in each of many episodes, and how many succeeded."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError, FairleadError
from fairlead.operate.client import RobotClient
from fairlead.operate.connection import choose_file
from fairlead.operate.goal_run import GoalOptions
from fairlead.operate.runner_choice import choose_runner
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import Admission
from fairlead.skill.manifest import load_skill
from fairlead_tools.cli.arming import YesOption
from fairlead_tools.cli.console import ProgressLine, echo, ends_like_ctrl_c, print_json, print_table
from fairlead_tools.cli.episodes import (
    HEADER,
    Episode,
    EpisodeRun,
    runs_since,
    succeeded,
    with_motion,
)
from fairlead_tools.cli.loading import load_first
from fairlead_tools.cli.options import (
    MAX_NUMBER,
    DeploymentOption,
    JsonOption,
    SkillArgument,
    example,
)
from fairlead_tools.cli.run import (
    DeadlineOption,
    PromptOption,
    RunnerOption,
    StallOption,
)
from fairlead_tools.cli.running_deployments import entries_of, wait_seen, wait_started
from fairlead_tools.cli.skill import installed_skill
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from fairlead_tools.writable import require_writable

MAX_EPISODES = 100_000
MAX_LATENCY_MS = 10_000.0
Pacing = Literal["realtime", "lockstep"]
Z_95 = 1.959964


def parse_seeds(text: str) -> list[int]:
    """``FIRST:END`` (without END) or single seeds, separated by commas."""
    seeds: list[int] = []
    for piece in text.split(","):
        first, colon, end = piece.partition(":")
        numbers = [first, end] if colon else [first]
        if not all(number.isdecimal() and int(number) <= MAX_NUMBER for number in numbers):
            raise typer.BadParameter(f"expected FIRST:END such as 0:20, or 3,5,8, got {text!r}")
        last = int(end) if colon else int(first) + 1
        if last <= int(first) or last - int(first) > MAX_EPISODES:
            raise typer.BadParameter(
                f"expected 1 to {MAX_EPISODES} seeds, the first below the end, got {text!r}"
            )
        seeds += range(int(first), last)
    if len(set(seeds)) < len(seeds):
        raise typer.BadParameter(f"expected each seed once, got {text!r}")
    return seeds


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """The 95 % interval of a share by Wilson's score; 0 to 1 without a trial."""
    if trials == 0:
        return 0.0, 1.0
    share, z2 = successes / trials, Z_95**2
    middle = share + z2 / (2 * trials)
    spread = Z_95 * math.sqrt(share * (1 - share) / trials + z2 / (4 * trials**2))
    low, high = ((middle + sign * spread) / (1 + z2 / trials) for sign in (-1, 1))
    return max(0.0, low), min(1.0, high)


@example("fairlead eval oracle-counter-to-cabinet --seeds 0:20")
def eval_command(
    skill: SkillArgument,
    seeds: Annotated[
        str, typer.Option(metavar="FIRST:END", help="0:20 is 0 to 19; or single ones: 3,5,8")
    ],
    deployment: DeploymentOption = None,
    runner: RunnerOption = "",
    prompt: PromptOption = "",
    deadline_ticks: DeadlineOption = 1200,
    stall_timeout: StallOption = 30.0,
    reset_stops: Annotated[
        bool,
        typer.Option("--reset-stops", help="acknowledge stops that nobody asked for, and go on"),
    ] = False,
    pacing: Annotated[
        Pacing | None, typer.Option(help="on a copy of the robot, started for this")
    ] = None,
    latency_ms: Annotated[
        float | None,
        typer.Option(
            min=0.0, max=MAX_LATENCY_MS, metavar="MS",
            help="each answer of the policy comes so much later; on a copy of the robot",
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option(file_okay=False, help="folder for pictures of what failed")
    ] = Path("out/eval"),
    yes: YesOption = False,
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Run SKILL once in a new simulated episode of each seed, on the robot that runs.

    Prints a row for each, and the share that succeeded with its 95 % interval (Wilson). Ctrl-C
    cancels the goal and prints what there is. A stop ends it, unless --reset-stops. STALLS: how
    often rows ran out; SEAM: the largest step from one chunk to the next, of the range commanded.
    Episodes that ended by an error, a fault or a cancel are no trials: named, not counted, exit 1.
    A policy that breaks once it was asked has failed.
    """
    wanted, skill = parse_seeds(seeds), installed_skill(skill)
    manifest, file = load_skill(skill), choose_file(deployment)
    chosen = load_deployment(file)
    named = choose_runner(chosen, skill, runner)
    wish = GoalOptions(skill, prompt, deadline_ticks, stall_timeout, named)
    admission = Admission(manifest, load_robot(chosen.robot))
    admission.require()
    require_writable("eval: --out", out)
    own = _Own(pacing, latency_ms) if pacing is not None or latency_ms is not None else None
    done: list[Episode] = []
    ended_by: BaseException | None = None
    began_s = time.time()
    state: Path | None = None
    with ends_like_ctrl_c(), ProgressLine(as_json) as line:
        try:
            with _client(file, own, named, out, line) as (client, state):
                client.wait_gate_follows()
                admission.require(client.hal_status())
                run = EpisodeRun(client, wish, line, reset_stops, yes)
                run.go_on()
                load_first(client, wish, line)
                for seed in wanted:
                    done.append(run.episode(seed, done, len(wanted)))
                    run.go_on()
        except (FairleadError, KeyboardInterrupt) as error:
            ended_by = error
        if state is not None and done:
            line.show("reading the gate's decision log")
            try:
                done = with_motion(done, runs_since(state, began_s), skill, out)
            except (FairleadError, OSError, KeyboardInterrupt) as error:  # what there is is printed
                ended_by = ended_by or _unread(out, error)
    _print(skill, wanted, done, ended_by, own, as_json)
    if isinstance(ended_by, FairleadError) and as_json:
        raise typer.Exit(1)  # said in the document
    if ended_by is not None:
        raise ended_by
    if not all(one.is_trial for one in done):
        raise typer.Exit(1)


def _unread(out: Path, error: BaseException) -> BaseException:
    """An error of a file, as one that says what is missing."""
    if not isinstance(error, OSError):
        return error
    return ConfigError(f"eval: no pictures and stalls: {error.filename or out}: {error.strerror}")


@dataclass(frozen=True)
class _Own:
    """What a copy of the robot does otherwise; None: nothing."""

    pacing: Pacing | None
    latency_ms: float | None


@contextmanager
def _client(
    file: Path, own: _Own | None, runner: str, out: Path, line: ProgressLine
) -> Iterator[tuple[RobotClient, Path | None]]:
    """A client of the robot that runs, or of a copy of it, and where its services' state is."""
    if own is None:
        wait_started(file, lambda text: echo(text, err=True))
        with RobotClient(load_deployment(file), by="fairlead eval") as client:
            wait_seen(client, file)
            yield client, _state_folder(file)
        return
    added = {} if own.latency_ms is None else {runner: {"added_latency_ms": own.latency_ms}}
    wish = ScratchOptions(pacing=own.pacing, options=added)
    scratch = make_scratch(file, out / "state", wish)
    line.show(f"starting {', '.join(scratch.deployment.services)}")
    with scratch_robot(scratch) as robot:
        yield robot.client, scratch.state_dir


def _state_folder(file: Path) -> Path | None:
    here = entries_of(file)
    return Path(here[0].state_dir) if here else None


def _print(
    skill: str,
    wanted: Sequence[int],
    done: Sequence[Episode],
    ended_by: BaseException | None,
    own: _Own | None,
    as_json: bool,
) -> None:
    trials = [one for one in done if one.is_trial]
    wins = succeeded(trials)
    by_policy = sum(one.outcome == "succeeded" and one.decided_by == "policy" for one in trials)
    low, high = wilson(wins, len(trials))
    ticks = [one.ticks for one in done if one.outcome == "succeeded"]
    median = statistics.median(ticks) if ticks else None
    if as_json:
        document: dict[str, Any] = {
            "skill": skill, "seeds": len(wanted), "pacing": own.pacing if own else None,
            "latency_ms": own.latency_ms if own else None,
            "episodes": [asdict(one) for one in done],
            "trials": len(trials), "succeeded": wins, "by_policy": by_policy,
            "interval_95": [round(low, 4), round(high, 4)],
            "median_ticks": median,
            "error": str(ended_by) or "interrupted" if ended_by is not None else None,
        }  # fmt: skip
        print_json(document)
        return
    if not done:
        return
    print_table(HEADER, [one.row for one in done])
    for picture in (one.picture for one in done if one.picture):
        echo(f"  {picture}")
    missing = f", {len(wanted) - len(done)} not run" if len(done) < len(wanted) else ""
    if len(trials) < len(done):
        missing += f", {len(done) - len(trials)} not counted: ended by an error or a cancel"
    if by_policy:
        missing = f" ({by_policy} by the policy's own word){missing}"
    typical = f"; median of their ticks: {median:g}" if median is not None else ""
    echo(
        f"{skill}: {wins} of {len(trials)} succeeded{missing}; 95 % interval "
        f"{100 * low:.0f} to {100 * high:.0f} %{typical}"
    )
