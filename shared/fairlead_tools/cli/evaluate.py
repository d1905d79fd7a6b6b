"""``fairlead eval SKILL``: one goal in each of many episodes, and how many succeeded."""

from __future__ import annotations

import math
import re
import statistics
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.registry import Registry
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
from fairlead_tools.record.run_log import Run, read_run
from fairlead_tools.record.smoothness import smoothness
from fairlead_tools.record.timeline import draw_timeline
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot

MAX_EPISODES = 100_000
MAX_LATENCY_MS = 10_000.0
Pacing = Literal["realtime", "lockstep"]
Z_95 = 1.959964
_ASKED_BY = re.compile("stopped: by ([^:]*): ")
_HEADER = ("SEED", "OUTCOME", "TICKS", "REFUSED", "STARVED", "STALLS", "SEAM", "STOPS", "WHY")


@dataclass(frozen=True)
class Episode:
    """How one goal went.

    ticks: from its first to its last. refusals: chunks refused or cut short, by check.
    starved: ticks in which no released row was left. stops: protective stops and latches.
    stalls, seam_step: see `smoothness`; None where the gate's log is not on this host.
    picture: the timeline of a goal that did not succeed, "" without one.
    """

    seed: int
    outcome: str
    decided_by: str
    why: str
    ticks: int
    refusals: dict[str, int]
    starved: int
    stops: int
    first_tick: int
    last_tick: int
    session: int
    stalls: int | None = None
    seam_step: float | None = None
    picture: str = ""

    @property
    def row(self) -> tuple[object, ...]:
        """Cells under `_HEADER`."""
        codes = ", ".join(f"{count} {code}" for code, count in sorted(self.refusals.items()))
        cells = (self.seed, self.outcome, self.ticks, codes or "-")
        stalls = "-" if self.stalls is None else self.stalls
        seam = "-" if self.seam_step is None else f"{self.seam_step:.2f}"
        return (*cells, self.starved, stalls, seam, self.stops, self.why)


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
    """
    wanted, skill = parse_seeds(seeds), installed_skill(skill)
    manifest, file = load_skill(skill), choose_file(deployment)
    chosen = load_deployment(file)
    named = choose_runner(chosen, skill, runner)
    wish = GoalOptions(skill, prompt, deadline_ticks, stall_timeout, named)
    admission = Admission(manifest, load_robot(chosen.robot))
    admission.require()
    own = _Own(pacing, latency_ms) if pacing is not None or latency_ms is not None else None
    done: list[Episode] = []
    ended_by: BaseException | None = None
    began_s = time.time()
    state: Path | None = None
    with ProgressLine(as_json) as line:
        try:
            with _client(file, own, named, out, line) as (client, state):
                client.wait_gate_follows()
                admission.require(client.hal_status())
                run = _Run(client, wish, line, reset_stops, yes)
                for seed in wanted:
                    done.append(run.episode(seed, done, len(wanted)))
                    run.go_on()
        except (FairleadError, KeyboardInterrupt) as error:
            ended_by = error
        if state is not None and done:
            line.show("reading the gate's decision log")
            done = _with_motion(done, _runs(state, began_s), skill, out)
    _print(skill, wanted, done, ended_by, own, as_json)
    if isinstance(ended_by, FairleadError) and as_json:
        raise typer.Exit(1)  # said in the document
    if ended_by is not None:
        raise ended_by


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
    here = [one for one in Registry().entries() if Path(one.deployment) == file]
    return Path(here[0].state_dir) if here else None


def _runs(state: Path, since_s: float) -> list[Run]:
    logs = [path for path in state.rglob("*.decisions") if path.stat().st_mtime >= since_s]
    return [read_run(path) for path in sorted(logs)]


def _with_motion(
    done: Sequence[Episode], runs: Sequence[Run], skill: str, out: Path
) -> list[Episode]:
    """The episodes with what the gate's log says of them, and a picture of each that failed."""
    told = []
    for one in done:
        parts = [run.between(one.first_tick, one.last_tick, one.session) for run in runs]
        run = max(parts, key=lambda part: len(part.joints), default=None)
        if run is not None and run.joints:
            robot = load_robot(run.header.robot)
            motion = smoothness(run, robot)
            one = replace(one, stalls=motion.stalls, seam_step=motion.seam_step)
            if one.outcome != "succeeded":
                path = out / f"{skill}-seed-{one.seed}.png"
                out.mkdir(parents=True, exist_ok=True)
                title = f"{skill}, seed {one.seed}: {one.outcome} after {one.ticks} ticks"
                draw_timeline(run, robot, title, path)
                one = replace(one, picture=str(path))
        told.append(one)
    return told


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
            result.first_tick, result.last_tick, gate.session,
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
    own: _Own | None,
    as_json: bool,
) -> None:
    succeeded = _succeeded(done)
    low, high = wilson(succeeded, len(done))
    ticks = [one.ticks for one in done if one.outcome == "succeeded"]
    median = statistics.median(ticks) if ticks else None
    if as_json:
        document: dict[str, Any] = {
            "skill": skill, "seeds": len(wanted), "pacing": own.pacing if own else None,
            "latency_ms": own.latency_ms if own else None,
            "episodes": [asdict(one) for one in done],
            "succeeded": succeeded, "interval_95": [round(low, 4), round(high, 4)],
            "median_ticks": median,
            "error": str(ended_by) or "interrupted" if ended_by is not None else None,
        }  # fmt: skip
        print_json(document)
        return
    if done:
        print_table(_HEADER, [one.row for one in done])
    for picture in (one.picture for one in done if one.picture):
        echo(f"  {picture}")
    missing = f", {len(wanted) - len(done)} not run" if len(done) < len(wanted) else ""
    typical = f"; median of their ticks: {median:g}" if median is not None else ""
    echo(
        f"{skill}: {succeeded} of {len(done)} succeeded{missing}; 95 % interval "
        f"{100 * low:.0f} to {100 * high:.0f} %{typical}"
    )
