"""The campaigns of one robot in blocks: each by itself, from a seed of its own, in any process."""

from __future__ import annotations

import hashlib
import pickle
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from bench.equipment.real_gate import TOOL
from bench.soundness.chunk_rows import Row
from bench.soundness.episodes import episode
from bench.soundness.followed import Soundness
from bench.soundness.gate_loop import GateLoop
from bench.soundness.kinematic_campaign import KinematicCampaign
from bench.soundness.simulated_campaign import Simulated, SimulatedCampaign
from bench.soundness.usability import Usability, demonstrate
from fairlead.messages import FloatArray
from fairlead.paths import built_program, gate_config
from fairlead_tools.measure.driven_robot import DrivenRobot

Kind = Literal["kinematic", "simulated", "usability"]
SIZES: dict[Kind, int] = {"kinematic": 2000, "simulated": 1500, "usability": 5}
RECORDED_TICKS = 400
TOLD_MOST = 20
Found = Soundness | Simulated | Usability
T = TypeVar("T", Soundness, Simulated, Usability)


@dataclass(frozen=True)
class Block:
    """A part of a campaign's work.

    number: of its kind, from 0 on, which its seeds follow from. amount: of chunks to judge, rows
    to execute or demonstrations to give.
    """

    robot: str
    kind: Kind
    number: int
    amount: int


def blocks_of(robot: str, kind: Kind, amount: int, first: int = 0) -> list[Block]:
    """So much of one kind, cut up. first: number of the first block."""
    size = SIZES[kind]
    starts = range(0, amount, size)
    return [Block(robot, kind, i, min(size, amount - at)) for i, at in enumerate(starts, first)]


def work(block: Block, on_progress: Callable[[str], None] = lambda what: None) -> Found:
    """Do one block."""
    driven, rows, around = _recorded(block.robot)
    if block.kind == "kinematic":
        campaign = KinematicCampaign(driven.robot, rows, around, seed=block.number + 1)
        return campaign.run(block.amount, on_progress)
    loop = GateLoop(driven)
    try:
        if block.kind == "simulated":
            return SimulatedCampaign(loop, block.number).run(block.amount, on_progress)
        first = block.number * SIZES["usability"]
        return demonstrate(loop, range(first, first + block.amount), on_progress)
    finally:
        loop.close()


def kept_work(block: Block, folder: Path) -> Found:
    """The same, unless ``folder`` has it from this very gate and these limits already."""
    gate = hashlib.sha256(built_program(TOOL).read_bytes())
    gate.update(gate_config(block.robot, "sim").read_bytes())
    name = f"{block.robot}-{block.kind}-{block.number}-{block.amount}-{gate.hexdigest()[:12]}"
    file = folder / f"{name}.pickle"
    if file.exists():
        kept: Found = pickle.loads(file.read_bytes())  # noqa: S301  # written by ourselves
        return kept
    found = work(block)
    folder.mkdir(parents=True, exist_ok=True)
    unfinished = file.with_suffix(".new")
    unfinished.write_bytes(pickle.dumps(found))
    unfinished.rename(file)
    return found


def merged(parts: Sequence[T]) -> T:
    """What several blocks of one kind found, in one."""
    whole = type(parts[0])()
    for field in fields(whole):
        values: list[Any] = [getattr(part, field.name) for part in parts]
        setattr(whole, field.name, _sum(values))
    return whole


def _sum(values: list[Any]) -> Any:
    first = values[0]
    if isinstance(first, Counter):
        return sum(values, Counter())
    if isinstance(first, dict):
        return {key: min(value[key] for value in values) for key in first}
    if isinstance(first, list):
        return [line for value in values for line in value[:TOLD_MOST]][:TOLD_MOST]
    return sum(values)


@cache
def _recorded(robot: str) -> tuple[DrivenRobot, list[Row], FloatArray]:
    """The robot, rows of its demonstration, and the configuration before each."""
    driven = DrivenRobot(robot)
    ticks = list(islice(episode(driven, 0), RECORDED_TICKS))
    around = np.stack([tick.before.positions for tick in ticks])
    return driven, [tick.commands for tick in ticks], around
