"""Compare two episodes bit for bit, and say where they part."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fairlead_tools.parity.episode_trace import EpisodeTrace

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
