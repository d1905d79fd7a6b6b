"""What one episode computed, as bytes, and where two episodes differ first."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np


@dataclass
class EpisodeTrace:
    """One episode.

    observations: float64 layout vectors, one per policy call.
    pictures: one JSON object per policy call: by name, the hash of what the policy got.
    actions: float32 ``[H, dim]``, one per policy call.
    packed: float32 vectors given to ``env.step``, one per tick after the reset.
    qpos, qvel: float64 simulator state before each of those steps.
    held: whether any part held in that tick; empty where nobody asked.
    succeeded: the task's own check at the end.
    """

    observations: list[bytes] = field(default_factory=list)
    pictures: list[bytes] = field(default_factory=list)
    actions: list[bytes] = field(default_factory=list)
    packed: list[bytes] = field(default_factory=list)
    qpos: list[bytes] = field(default_factory=list)
    qvel: list[bytes] = field(default_factory=list)
    held: list[bool] = field(default_factory=list)
    succeeded: bool = False

    def until(self, tick: int) -> EpisodeTrace:
        """Vectors of the ticks before ``tick``, states before each and, if there, at ``tick``."""
        return EpisodeTrace(
            packed=self.packed[:tick], qpos=self.qpos[: tick + 1], qvel=self.qvel[: tick + 1]
        )


_NUMBERS = {
    "observations": "<f8",
    "actions": "<f4",
    "packed": "<f4",
    "qpos": "<f8",
    "qvel": "<f8",
}


@dataclass(frozen=True)
class Comparison:
    """One quantity over the whole episode.

    deployed, local: how many records each side has.
    difference: where they first differ and by how much, "" if nowhere.
    """

    quantity: str
    deployed: int
    local: int
    difference: str

    @property
    def same(self) -> bool:
        """Whether both sides agree bit for bit."""
        return not self.difference


def compare(
    deployed: EpisodeTrace, local: EpisodeTrace, quantities: Sequence[str] = tuple(_NUMBERS)
) -> list[Comparison]:
    """The quantities, by default all in the order in which they are computed."""
    return [_compare_one(name, deployed, local) for name in quantities]


def _compare_one(name: str, deployed: EpisodeTrace, local: EpisodeTrace) -> Comparison:
    ours: list[bytes] = getattr(deployed, name)
    theirs: list[bytes] = getattr(local, name)
    difference = ""
    for index, (one, other) in enumerate(zip(ours, theirs, strict=False)):
        if one != other:
            first = _first_picture if name == "pictures" else _first_number
            difference = f"record {index}: {first(one, other, _NUMBERS.get(name, ''))}"
            break
    if not difference and len(ours) != len(theirs):
        difference = f"{len(ours)} records deployed, {len(theirs)} beside them"
    if not difference and not ours:
        difference = "nothing was recorded"
    return Comparison(name, len(ours), len(theirs), difference)


def _first_picture(one: bytes, other: bytes, kind: str) -> str:
    ours, theirs = json.loads(one), json.loads(other)
    name = next(name for name in sorted(ours | theirs) if ours.get(name) != theirs.get(name))
    return f"picture {name}: deployed {ours.get(name)}, beside it {theirs.get(name)}"


def _first_number(one: bytes, other: bytes, kind: str) -> str:
    if len(one) != len(other):
        return f"{len(one)} bytes deployed, {len(other)} beside them"
    a, b = np.frombuffer(one, kind), np.frombuffer(other, kind)
    bits = np.frombuffer(one, np.uint8).reshape(len(a), -1)
    other_bits = np.frombuffer(other, np.uint8).reshape(len(a), -1)
    index = int(np.flatnonzero((bits != other_bits).any(axis=1))[0])
    return f"number {index}: deployed {a[index]!r}, beside it {b[index]!r}"
