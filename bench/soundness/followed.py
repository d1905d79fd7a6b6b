"""What a kinematic campaign found."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from bench.soundness.arena import RULES, SPEED


@dataclass
class Soundness:
    """rows: that acted, of each chunk under several shares; in_realtime: of them, those judged so.

    after_hold: of the rows, those of further chunks, in realtime of some that came in a held tick.
    cut: of these runs, those that the gate ended before the last released row. breaches: by rule,
    places where it was broken, or would have been by a hold. worst: least room left, by rule. near:
    places within the clearance that the gate keeps. told: one line for each of the first breaches.
    """

    chunks: int = 0
    by_kind: Counter[str] = field(default_factory=Counter)
    released: int = 0
    truncated: Counter[int] = field(default_factory=Counter)
    refused: Counter[int] = field(default_factory=Counter)
    rows: int = 0
    in_realtime: int = 0
    after_hold: int = 0
    cut: Counter[int] = field(default_factory=Counter)
    configurations: int = 0
    not_reached: int = 0
    near: int = 0
    breaches: Counter[str] = field(default_factory=Counter)
    worst: dict[str, float] = field(default_factory=lambda: dict.fromkeys((*RULES, SPEED), np.inf))
    told: list[str] = field(default_factory=list)

    def see(self, rule: str, room: float, what: str) -> None:
        """So much room is left of a rule; below 0, or no number, it is broken."""
        self.worst[rule] = min(self.worst[rule], room)
        if not room >= 0.0:
            self.breaches[rule] += 1
            self.told.append(f"{rule} {room:.5f}: {what}")
