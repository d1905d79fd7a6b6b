"""All campaigns of one robot, in this process or in several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from time import monotonic
from typing import Any

from bench.soundness.blocks import Block, Found, Kind, blocks_of, kept_work, merged, work
from bench.soundness.followed import Soundness
from bench.soundness.simulated_campaign import Simulated
from bench.soundness.usability import Usability


@dataclass(frozen=True)
class Amount:
    """chunks to judge, rows to execute in the simulator, demonstrations to give.

    first: number of the first block of each, which all seeds follow from.
    """

    chunks: int
    rows: int
    episodes: int
    first: int = 0


@dataclass(frozen=True)
class Results:
    """What one robot's campaigns found."""

    robot: str
    kinematic: Soundness
    simulated: Simulated
    usability: Usability


def run(robot: str, amount: Amount, on_progress: Callable[[str], None]) -> Results:
    """Judge and follow, execute, demonstrate: one block after the other."""
    found = {block: work(block, on_progress) for block in _blocks(robot, amount)}
    return _results(robot, found)


def run_all(
    amounts: dict[str, Amount], workers: int, keep: Path, on_progress: Callable[[str], None]
) -> list[Results]:
    """Every robot's, in so many processes. What ``keep`` has already is not done again."""
    blocks = [block for robot, amount in amounts.items() for block in _blocks(robot, amount)]
    began, found = monotonic(), dict[Block, Found]()
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        waiting = {pool.submit(kept_work, block, keep): block for block in blocks}
        for done in as_completed(waiting):
            block = waiting[done]
            found[block] = done.result()
            breaches = dict(getattr(found[block], "breaches", {}))
            on_progress(
                f"{_pace(found, len(blocks), monotonic() - began)}: "
                f"{block.robot} {block.kind} {block.number}, breaches {breaches}"
            )
            for line in getattr(found[block], "told", []):
                on_progress(line)
    return [_results(robot, found) for robot in amounts]


def _pace(found: dict[Block, Found], blocks: int, took_s: float) -> str:
    rows = sum(one.rows for one in found.values() if isinstance(one, Simulated))
    left_s = took_s / len(found) * (blocks - len(found))
    return (
        f"{len(found)} of {blocks} blocks after {took_s:.0f} s, {rows} rows executed "
        f"({rows / took_s:.0f} a second), about {left_s / 60.0:.0f} min left"
    )


def _blocks(robot: str, amount: Amount) -> list[Block]:
    wanted: list[tuple[Kind, int]] = [
        ("kinematic", amount.chunks),
        ("simulated", amount.rows),
        ("usability", amount.episodes),
    ]
    return [
        block for kind, count in wanted for block in blocks_of(robot, kind, count, amount.first)
    ]


def _results(robot: str, found: dict[Block, Found]) -> Results:
    def of(kind: Kind, empty: Any) -> Any:
        mine = [block for block in found if (block.robot, block.kind) == (robot, kind)]
        parts: Sequence[Any] = [found[one] for one in sorted(mine, key=lambda one: one.number)]
        return merged(parts) if parts else empty

    return Results(
        robot,
        of("kinematic", Soundness()),
        of("simulated", Simulated()),
        of("usability", Usability()),
    )
