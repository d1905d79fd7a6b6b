"""One goal of a late policy on the robot: which ticks had a row, and what the seams were like."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from bench.chunk_async.executors import Executed, latest_wins, synchronous, theory
from bench.chunk_async.stage import (
    BLEND_TICKS,
    JITTER,
    LOST,
    OVERTAKEN,
    TICK_S,
    AsyncStage,
    Way,
)
from bench.equipment.motion_log import MotionLine, longest_tick_ms
from bench.equipment.turning import BASE
from bench.faults.row import MachineLateError
from fairlead.messages import Hold

FULL_SPEED = 1.5
"""Of the turning base [rad/s]: what a policy's 1 means."""


@dataclass(frozen=True)
class Run:
    """What one goal showed.

    horizon: H, rows of each answer.
    longest_ticks: d, from an observation to its answer's first row, at the longest latency that
        may be, or was on a busy machine.
    answers, ticks: that counted. stalls: ticks in which the base had no row.
    other_holds: ticks in which it held for another reason: the machine was late.
    theory: the duty of one question at a time under ideal conditions.
    seam, naive: largest step [rad/s] where one answer goes over to the next, as it was executed
        and as it would have been at once.
    longest_tick_ms: of the HAL; far above 50 the machine was busy with other things.
    """

    latency_ms: float
    way: str
    horizon: int
    longest_ticks: int
    answers: int
    ticks: int
    stalls: int
    other_holds: int
    theory: float
    seam: float
    naive: float
    longest_tick_ms: float
    synchronous: Executed
    latest_wins: Executed

    @property
    def duty(self) -> float:
        """Share of ticks with a row."""
        return 1.0 - self.stalls / self.ticks

    @property
    def never_stalls(self) -> bool:
        """Whether rows are promised never to run out: H >= 2d + 1."""
        return 2 * self.longest_ticks + 1 <= self.horizon


@dataclass(frozen=True)
class Answer:
    """A line of the policy's log.

    tick: of its observation. speed: that it says. asked_s, answered_s: CLOCK_MONOTONIC.
    """

    tick: int
    speed: float
    asked_s: float
    answered_s: float


def run(stage: AsyncStage, latency_s: float, way: Way, seconds: float, seed: int) -> Run:
    """Run a goal, and count what happens in so much time after its cold start.

    Raises:
        MachineLateError: the goal ended by itself, as where the gate hears of no state for 250 ms,
            or its runner was not seen for a while.
    """
    skill, log = stage.add_skill(latency_s, way, seed)
    goal = stage.start_late(skill)
    began_ns = stage.bad_network(seed)
    ended = threading.Event()
    goal.add_done_callback(lambda _: ended.set())
    gone = ended.wait(seconds)
    ended_ns = time.monotonic_ns()
    stage.good_network()
    if gone:
        if error := goal.exception():
            _cancel(stage)
            raise MachineLateError(f"the goal was given up: {error}") from error
        raise MachineLateError(f"the goal ended before: {goal.result().result}")
    stage.finish(goal)
    lines = [line for line in stage.motion.since(began_ns) if line.stamp_ns < ended_ns]
    return judged(latency_s, way, answers_of(log), lines, stage)


def _cancel(stage: AsyncStage) -> None:
    """End a goal that goes on though nobody follows it any more."""
    left = stage.client.goal_feedback("runner")
    if left.is_running:
        stage.client.cancel("runner", left.goal_id)


def answers_of(log: Path) -> list[Answer]:
    """The policy's answers, oldest first; the last may have come after the goal's end."""
    entries = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]
    return [Answer(one["tick"], one["speed"], one["asked_s"], one["answered_s"]) for one in entries]


def latencies_of(answers: Sequence[Answer]) -> list[float]:
    """What each answer took [ticks]."""
    return [(one.answered_s - one.asked_s) / TICK_S for one in answers]


def note_ways(
    stage: AsyncStage,
    answers: Sequence[Answer],
    lines: Sequence[MotionLine],
    in_force: Sequence[int | None],
) -> None:
    """Keep how long after its tick an observation was asked about, and an answer before its own.

    The shortest of all runs are the ways themselves [ticks].
    """
    began_s = {line.tick: line.stamp_ns * 1e-9 for line in lines}
    for one in answers:
        if one.tick in began_s:
            stage.ways[0].append((one.asked_s - began_s[one.tick]) / TICK_S)
    first: dict[int, MotionLine] = {}
    for line, seq in zip(lines, in_force, strict=True):
        if seq is not None:
            first.setdefault(seq, line)
    for seq, line in list(first.items())[1:]:
        stage.ways[1].append((began_s[line.tick] - answers[seq - 1].answered_s) / TICK_S)


def shortest_ways(stage: AsyncStage) -> tuple[float, float]:
    """Of all runs so far [ticks]."""
    there, back = (max(0.0, min(ways, default=0.0)) for ways in stage.ways)
    return there, back


def whole_cycles(in_force: Sequence[int | None]) -> slice:
    """Cycles that were not cut: from where an answer begins to act to where the last one does."""
    newest, begins = None, []
    for at, seq in enumerate(in_force):
        if seq is not None and seq != newest:
            newest = seq
            begins.append(at)
    return slice(begins[1], begins[-1])


def judged(
    latency_s: float, way: Way, answers: Sequence[Answer], lines: Sequence[MotionLine],
    stage: AsyncStage,
) -> Run:  # fmt: skip
    """What the HAL's log shows."""
    in_force = [stage.seq(line) for line in lines]
    note_ways(stage, answers, lines, in_force)
    cycles = whole_cycles(in_force)
    first, last = in_force[cycles.start], in_force[cycles.stop]
    assert first is not None and last is not None  # an answer begins to act in these
    counted = answers[first - 1 : last]
    lines, in_force = lines[cycles], in_force[cycles]
    holds = [Hold(line.holds[BASE]) for line in lines if line.holds[BASE] != Hold.NONE]
    latencies = latencies_of(counted)
    speeds = [one.speed * FULL_SPEED for one in counted]
    seam, naive = seam_steps(lines, in_force, answers, stage)
    return Run(
        latency_ms=latency_s * 1e3,
        way=way.name,
        horizon=way.horizon,
        longest_ticks=int(max(latency_s * (1.0 + JITTER) / TICK_S, *latencies)) + 1,
        answers=len(counted),
        ticks=len(lines),
        stalls=holds.count(Hold.NO_ROW),
        other_holds=len(holds) - holds.count(Hold.NO_ROW),
        theory=theory(latencies, way.horizon, LOST + OVERTAKEN, shortest_ways(stage)),
        seam=seam,
        naive=naive,
        longest_tick_ms=longest_tick_ms(list(lines)),
        synchronous=synchronous(latencies, speeds, way.horizon),
        latest_wins=latest_wins(latencies, speeds, way.horizon),
    )


def seam_steps(
    lines: Sequence[MotionLine],
    in_force: Sequence[int | None],
    answers: Sequence[Answer],
    stage: AsyncStage,
) -> tuple[float, float]:
    """Largest step [rad/s] within a seam, as executed, and where each answer counts at once."""
    executed = [stage.base.speed(line) for line in lines]
    seam = naive = 0.0
    for at, (before, after) in enumerate(pairwise(in_force), 1):
        if before is None or after is None or before == after:
            continue
        speeds = [answers[seq - 1].speed * FULL_SPEED for seq in (before, after)]
        naive = max(naive, abs(speeds[1] - speeds[0]))
        for one, other in pairwise(executed[at - 1 : at + BLEND_TICKS + 1]):
            if one is not None and other is not None:
                seam = max(seam, abs(other - one))
    return seam, naive
