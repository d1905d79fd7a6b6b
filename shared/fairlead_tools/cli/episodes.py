"""``fairlead episode``, and those of ``fairlead eval``: a goal in each, and what the log says."""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from fairlead.errors import RefusedError
from fairlead.messages import (
    GateState,
    GateStatus,
    GoalResult,
    Outcome,
    ResetEpisodeReply,
    Verdict,
    decode,
)
from fairlead.operate.client import SEEN_S, RobotClient
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Sample
from fairlead_tools.cli.arming import armed
from fairlead_tools.cli.console import ProgressLine, echo
from fairlead_tools.cli.options import MAX_NUMBER, DeploymentOption, choose_deployment, example
from fairlead_tools.cli.status import state_and_cause

if TYPE_CHECKING:
    from fairlead_tools.record.run_log import Run

NO_TRIAL = frozenset(
    {
        "already_solved", "camera_lost", "cancelled", "claim_refused", "error", "hal_fault",
        "internal_error", "new_session", "no_answer", "not_admitted",
    }
)  # fmt: skip
"""Kinds of ends, beside those of layouts and before the policy was asked, that say nothing of how
well the skill does its task."""
HEADER = ("SEED", "OUTCOME", "TICKS", "REFUSED", "STARVED", "STALLS", "SEAM", "STOPS", "WHY")
READY_WAIT_S, PAUSE_S = 15.0, 0.2
T = TypeVar("T")
_ASKED_BY = re.compile("stopped: by ([^:]*): ")


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
    def is_trial(self) -> bool:
        """Whether the skill could show what it can."""
        kind, never_asked = self.why.partition(":")[0], not self.first_tick
        is_none = never_asked or kind in NO_TRIAL or kind.startswith("layout_")
        return self.outcome == "succeeded" or not is_none

    @property
    def row(self) -> tuple[object, ...]:
        """Cells under `HEADER`."""
        codes = ", ".join(f"{count} {code}" for code, count in sorted(self.refusals.items()))
        cells = (self.seed, self.outcome, self.ticks, codes or "-")
        stalls = "-" if self.stalls is None else self.stalls
        seam = "-" if self.seam_step is None else f"{self.seam_step:.2f}"
        return (*cells, self.starved, stalls, seam, self.stops, self.why)


class EpisodeRun:
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
        """One goal in a new episode; with --reset-stops begun again, for a while, where refused."""
        try:
            return self._episode(seed, done, seeds)
        except RefusedError:
            if not self._reset_stops:
                raise
            self.go_on()
        return self._ask_again(lambda: self._episode(seed, done, seeds))

    def _episode(self, seed: int, done: Sequence[Episode], seeds: int) -> Episode:
        where = f"seed {seed}, {len(done) + 1} of {seeds}, {succeeded(done)} succeeded"
        self._line.show(f"{where} | new episode")
        begun = new_episode(self._client, seed)
        self._verdicts.clear()
        with armed(self._client, confirmed=self._yes):
            progress = run_goal(
                self._client, self._wish, lambda now: self._line.show(f"{where} | {now.line()}")
            )
            gate = self._client.gate_status()
        assert progress.result is not None
        result = progress.result
        episode = Episode(
            seed, result.outcome, result.decided_by, _why(result),
            result.last_tick - result.first_tick + 1 if result.first_tick else 0,
            self._refusals(), progress.starved, len(gate.stop_ids) + bool(gate.latch_id),
            result.first_tick, result.last_tick, gate.session,
        )  # fmt: skip
        if episode.is_trial and self._client.hal_status().episode_tick != begun.episode_tick:
            why = f"another began a new episode: the goal was none of seed {seed}"
            raise RefusedError("fairlead eval", why, "run one after the other")
        return episode

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
                self._ask_again(partial(self._client.reset, one))
        return True

    def _ask_again(self, ask: Callable[[], T]) -> T:
        """With --reset-stops: a robot that was just stopped is not ready at once.

        Raises:
            RefusedError: it was refused to the end.
        """
        deadline = time.monotonic() + READY_WAIT_S
        while True:
            try:
                return ask()
            except RefusedError:
                if not self._reset_stops or time.monotonic() > deadline:
                    raise
            time.sleep(PAUSE_S)

    def _on_verdict(self, sample: Sample) -> None:
        verdict = decode(Verdict, sample.payload)
        self._verdicts.setdefault((verdict.claim_id, verdict.seq), verdict)

    def _refusals(self) -> dict[str, int]:
        given = list(self._verdicts.values())
        return dict(Counter(f"G{one.code:03d}" for one in given if one.outcome != Outcome.RELEASED))


def _why(result: GoalResult) -> str:
    return f"{result.kind}: {result.detail}" if result.kind else ""


def succeeded(done: Sequence[Episode]) -> int:
    """How many did."""
    return sum(one.outcome == "succeeded" for one in done)


def runs_since(state: Path, since_s: float) -> list[Run]:
    """The decision logs below a folder that were written since a time (UNIX, s)."""
    logs = [path for path in state.rglob("*.decisions") if path.stat().st_mtime >= since_s]
    from fairlead_tools.record.run_log import read_run

    return [read_run(path) for path in sorted(logs)]


def with_motion(
    done: Sequence[Episode], runs: Sequence[Run], skill: str, out: Path
) -> list[Episode]:
    """The episodes with what the gate's log says of them, and a picture of each that failed."""
    from fairlead_tools.record.smoothness import smoothness
    from fairlead_tools.record.timeline import draw_timeline

    told = []
    for one in done:
        seen = runs if one.first_tick else ()  # it ended before its first observation
        parts = [run.between(one.first_tick, one.last_tick, one.session) for run in seen]
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


@example("fairlead episode --seed 7")
def episode_command(
    seed: Annotated[
        int, typer.Option(min=0, max=MAX_NUMBER, help="where things stand in the new scene")
    ] = 0,
    deployment: DeploymentOption = None,
) -> None:
    """Start a new episode of a simulator, without a goal, and wait until the robot stands in it.

    Disarms first. Refused while somebody has a claim, or the gate is stopped or latched.
    """
    chosen = choose_deployment(deployment)
    with RobotClient(chosen, by="fairlead episode") as client:
        reply = new_episode(client, seed)
    echo(f"{chosen.id} is in a new episode, seed {seed}, from tick {reply.episode_tick} on")
    echo("next: fairlead run SKILL, or fairlead arm")


def new_episode(client: RobotClient, seed: int) -> ResetEpisodeReply:
    """Disarm, start a new episode, and return once the HAL confirms that the robot stands in it.

    Raises:
        RefusedError: a goal runs, somebody has a claim, the gate is stopped or latched, the robot
            is real.
        NoAnswerError: the gate or the HAL does not answer.
    """
    gate = client.gate_status()
    _require_no_stop(gate)
    for goal in client.status(timeout_s=SEEN_S).runners:
        if goal.is_running:  # without a claim, say: it loads its policy
            why = f"a new episode would be under the goal of {goal.source}, which runs {goal.skill}"
            raise RefusedError("fairlead", why, f"fairlead cancel {goal.source}")
    if gate.claims:
        claim = gate.claims[0]
        why = f"a new episode would end the claim of {claim.source}, which runs {claim.skill}"
        is_runners = claim.source in client.deployment.runners
        fix = f"fairlead cancel {claim.source}" if is_runners else "end it where it was started"
        raise RefusedError("fairlead", why, fix)
    if gate.state == GateState.ARMED:
        client.disarm()
    try:
        return client.reset_episode(seed)
    except RefusedError:
        _require_no_stop(client.gate_status())  # its answer has the id
        raise


def _require_no_stop(gate: GateStatus) -> None:
    if gate.state in (GateState.STOPPED, GateState.LATCHED):
        why = f"no new episode while the gate is {state_and_cause(gate)}"
        raise RefusedError("fairlead", why, gate.fix)
