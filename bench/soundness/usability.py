"""False refusals: what the gate says to good demonstrations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from bench.soundness.demonstrations import Demonstration, Rows
from bench.soundness.gate_loop import GateLoop
from bench.soundness.stops import kind_of, story_of
from fairlead.messages import Outcome, Verdict
from fairlead_tools.measure.driven_robot import DrivenRobot


@dataclass
class Usability:
    """chunks, episodes, succeeded, ticks: how many. refused, truncated: chunks by code.

    cut: those whose released rows were cut off before they acted.
    stops: by code and joint, each ended an episode. told: the first words of each kind.
    """

    episodes: int = 0
    succeeded: int = 0
    chunks: int = 0
    ticks: int = 0
    refused: Counter[int] = field(default_factory=Counter)
    truncated: Counter[int] = field(default_factory=Counter)
    cut: Counter[int] = field(default_factory=Counter)
    stops: Counter[str] = field(default_factory=Counter)
    told: list[str] = field(default_factory=list)


def demonstrate(
    loop: GateLoop[DrivenRobot], seeds: Sequence[int], on_progress: Callable[[str], None]
) -> Usability:
    """One demonstration of each seed under the gate's eyes."""
    found = Usability()
    for seed in seeds:
        _episode(loop, seed, found)
        on_progress(
            f"{loop.driven.robot.id}: demonstration of seed {seed}: {found.chunks} "
            f"chunks, refused {dict(found.refused)}, truncated {dict(found.truncated)}, "
            f"stops {dict(found.stops)}"
        )
    return found


def _episode(loop: GateLoop[DrivenRobot], seed: int, found: Usability) -> None:
    """Every other seed in realtime: the next chunk is asked for while the last one's rows act."""
    loop.begin(seed, pacing="realtime" if seed % 2 else "lockstep")
    expert = Demonstration(loop.driven, seed // 2)
    found.episodes += 1
    last_tick = 0
    while loop.tick <= expert.most_ticks:
        if seed % 2 and last_tick <= loop.tick + 1:
            rows = expert.chunk(loop.tick)[1:]  # the first one's tick has begun
            if expert.is_over():
                found.succeeded += 1
                return
            last_tick = _ask(loop, rows, seed, found)
        step = loop.advance("oracle")
        if loop.stop_cause:
            found.stops[kind_of(loop.stop_cause)] += 1
            found.told.append(f"seed {seed}, tick {loop.tick}: {story_of(loop.stop_cause)}")
            return
        if step is None:
            rows = expert.chunk(loop.tick)
            if expert.is_over():
                found.succeeded += 1
                return
            _ask(loop, rows, seed, found)
            continue
        found.ticks += 1
        _count_cut(loop, seed, found)
        if expert.is_over():
            found.succeeded += 1
            return


def _count_cut(loop: GateLoop[DrivenRobot], seed: int, found: Usability) -> None:
    for verdict in loop.take_cut():
        found.cut[verdict.code] += 1
        found.told.append(f"seed {seed}, tick {loop.tick}: cut off: {_why(verdict)}")


def _ask(loop: GateLoop[DrivenRobot], rows: Rows, seed: int, found: Usability) -> int:
    """The last tick that it releases a row for."""
    verdict = loop.propose(rows)
    found.chunks += 1
    if verdict.outcome == Outcome.RELEASED:
        return verdict.released_last
    by_code = found.refused if verdict.outcome == Outcome.REFUSED else found.truncated
    by_code[verdict.code] += 1
    found.told.append(f"seed {seed}, tick {loop.tick}: {_why(verdict)}")
    return verdict.released_last


def _why(verdict: Verdict) -> str:
    return (
        f"G{verdict.code:03d}, row {verdict.row}, {verdict.part} {verdict.axis}: "
        f"{verdict.value:.4g} against {verdict.limit:.4g} ({verdict.limit_source})"
    )
