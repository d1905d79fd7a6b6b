"""``fairlead eval SKILL``: one goal in each of many episodes, and how many succeeded."""

from __future__ import annotations

import math
import re
import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.errors import FairleadError, RefusedError
from fairlead.messages import GateState, GoalResult, Outcome, Verdict, decode
from fairlead.operate.client import RobotClient
from fairlead.operate.connection import choose_file
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.operate.runner_choice import choose_runner
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import Admission
from fairlead.skill.manifest import load_skill
from fairlead.wire.bus import Sample
from fairlead_tools.cli.arming import YesOption, armed
from fairlead_tools.cli.console import ProgressLine, echo, print_json, print_table
from fairlead_tools.cli.goals import (
    DeadlineOption,
    PromptOption,
    RunnerOption,
    StallOption,
    new_episode,
)
from fairlead_tools.cli.options import MAX_NUMBER, DeploymentOption, JsonOption, example
from fairlead_tools.cli.skill import SkillArgument, installed_skill
from fairlead_tools.cli.status import state_and_cause, wait_seen, wait_started

MAX_EPISODES = 100_000
Z_95 = 1.959964
_ASKED_BY = re.compile("stopped: by ([^:]*): ")
_HEADER = ("SEED", "OUTCOME", "TICKS", "REFUSED", "STARVED", "STOPS", "WHY")


@dataclass(frozen=True)
class Episode:
    """How one goal went.

    ticks: from its first to its last. refusals: chunks refused or cut short, by check.
    starved: ticks in which no released row was left. stops: protective stops and latches.
    """

    seed: int
    outcome: str
    decided_by: str
    why: str
    ticks: int
    refusals: dict[str, int]
    starved: int
    stops: int

    @property
    def row(self) -> tuple[object, ...]:
        """Cells under `_HEADER`."""
        codes = ", ".join(f"{count} {code}" for code, count in sorted(self.refusals.items()))
        cells = (self.seed, self.outcome, self.ticks, codes or "-")
        return (*cells, self.starved, self.stops, self.why)


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
    yes: YesOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run SKILL once in a new simulated episode of each seed, on the robot that runs.

    Prints a row for each, and the share that succeeded with its 95 % interval (Wilson). Ctrl-C
    cancels the goal and prints what there is. A stop ends it, unless --reset-stops.
    """
    wanted, skill = parse_seeds(seeds), installed_skill(skill)
    manifest, file = load_skill(skill), choose_file(deployment)
    chosen = load_deployment(file)
    named = choose_runner(chosen, skill, runner)
    wish = GoalOptions(skill, prompt, deadline_ticks, stall_timeout, named)
    admission = Admission(manifest, load_robot(chosen.robot))
    admission.require()
    wait_started(file, lambda line: echo(line, err=True))
    done: list[Episode] = []
    ended_by: BaseException | None = None
    try:
        with RobotClient(chosen, by="fairlead eval") as client, ProgressLine(as_json) as line:
            wait_seen(client, file)
            client.wait_gate_follows()
            admission.require(client.hal_status())
            run = _Run(client, wish, line, reset_stops, yes)
            for seed in wanted:
                done.append(run.episode(seed, done, len(wanted)))
                run.go_on()
    except (FairleadError, KeyboardInterrupt) as error:
        ended_by = error
    _print(skill, wanted, done, ended_by, as_json)
    if isinstance(ended_by, FairleadError) and as_json:
        raise typer.Exit(1)  # said in the document
    if ended_by is not None:
        raise ended_by


class _Run:
    """Episodes on one robot, one after the other."""

    def __init__(
        self,
        client: RobotClient,
        wish: GoalOptions,
        line: ProgressLine,
        reset_stops: bool,
        yes: bool,
    ) -> None:
        self._client, self._wish, self._line = client, wish, line
        self._reset_stops, self._yes = reset_stops, yes
        self._verdicts: dict[tuple[int, int], Verdict] = {}
        client.bus.subscribe(client.keys.verdict(wish.runner), self._on_verdict)

    def episode(self, seed: int, done: Sequence[Episode], seeds: int) -> Episode:
        """One goal in a new episode; begun once more after a stop that came before its goal."""
        try:
            return self._episode(seed, done, seeds)
        except RefusedError:
            if not self._reset_stops or not self.go_on():
                raise
        return self._episode(seed, done, seeds)

    def _episode(self, seed: int, done: Sequence[Episode], seeds: int) -> Episode:
        where = f"seed {seed}, {len(done) + 1} of {seeds}, {_succeeded(done)} succeeded"
        self._line.show(f"{where} | new episode")
        new_episode(self._client, seed)
        self._verdicts.clear()
        with armed(self._client, confirmed=self._yes):
            progress = run_goal(
                self._client, self._wish, lambda now: self._line.show(f"{where} | {now.line()}")
            )
            gate = self._client.gate_status()
        assert progress.result is not None
        result = progress.result
        return Episode(
            seed, result.outcome, result.decided_by, _why(result),
            result.last_tick - result.first_tick + 1 if result.first_tick else 0,
            self._refusals(), progress.starved, len(gate.stop_ids) + bool(gate.latch_id),
        )  # fmt: skip

    def go_on(self) -> bool:
        """Acknowledge stops, where that was asked for; whether there was one.

        Raises:
            RefusedError: there is one, and it was not; or a person's, who wants it to end.
        """
        gate = self._client.gate_status()
        if gate.state < GateState.STOPPED:
            return False
        by = _ASKED_BY.match(gate.cause)
        is_a_persons = by is not None and by[1] not in self._client.deployment.services
        if is_a_persons or not self._reset_stops:
            raise RefusedError("fairlead eval", f"the gate is {state_and_cause(gate)}", gate.fix)
        for one in (*gate.stop_ids, gate.latch_id):
            if one:
                self._client.reset(one)
        return True

    def _on_verdict(self, sample: Sample) -> None:
        verdict = decode(Verdict, sample.payload)
        self._verdicts.setdefault((verdict.claim_id, verdict.seq), verdict)

    def _refusals(self) -> dict[str, int]:
        given = list(self._verdicts.values())
        return dict(Counter(f"G{one.code:03d}" for one in given if one.outcome != Outcome.RELEASED))


def _why(result: GoalResult) -> str:
    return f"{result.kind}: {result.detail}" if result.kind else ""


def _succeeded(done: Sequence[Episode]) -> int:
    return sum(one.outcome == "succeeded" for one in done)


def _print(
    skill: str,
    wanted: Sequence[int],
    done: Sequence[Episode],
    ended_by: BaseException | None,
    as_json: bool,
) -> None:
    succeeded = _succeeded(done)
    low, high = wilson(succeeded, len(done))
    ticks = [one.ticks for one in done if one.outcome == "succeeded"]
    median = statistics.median(ticks) if ticks else None
    if as_json:
        document: dict[str, Any] = {
            "skill": skill, "seeds": len(wanted), "episodes": [asdict(one) for one in done],
            "succeeded": succeeded, "interval_95": [round(low, 4), round(high, 4)],
            "median_ticks": median,
            "error": str(ended_by) or "interrupted" if ended_by is not None else None,
        }  # fmt: skip
        print_json(document)
        return
    if done:
        print_table(_HEADER, [one.row for one in done])
    missing = f", {len(wanted) - len(done)} not run" if len(done) < len(wanted) else ""
    typical = f"; median of their ticks: {median:g}" if median is not None else ""
    echo(
        f"{skill}: {succeeded} of {len(done)} succeeded{missing}; 95 % interval "
        f"{100 * low:.0f} to {100 * high:.0f} %{typical}"
    )
