"""A policy that takes its time, and each time turns at one of two speeds: the worst for seams.

It runs in the robot's own policy process, from a copy in a skill's folder.
"""

from __future__ import annotations

import json
import random
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np

from fairlead.policy import Actions, Observation
from fairlead.skill.manifest import SkillManifest

TURN, LEADS_OVER = 8, 8
"""The column that turns the base; rows in which it leads over from a prefix."""
SPEEDS = (0.2, 0.6)
"""Of its full speed."""
COLD = 3.0
"""How often its usual time the first answer takes."""


class LatePolicy:
    """options: ``latency_s``, its ``jitter`` (a share), a ``seed``, ``continues``, and ``log``.

    log: a line for each answer: the observation's tick, the latency [s], the speed, and when it
    was asked and answered (CLOCK_MONOTONIC [s]).
    """

    def __init__(self, skill: SkillManifest, options: Mapping[str, Any]) -> None:
        self._rows, self._dim = skill.horizon, skill.action_contract.dim
        self._latency_s, self._jitter = options["latency_s"], options["jitter"]
        self._rng = random.Random(options["seed"])
        self._log = Path(options["log"])
        self._is_cold = True
        self.continues_rows = bool(options["continues"])

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, Any]) -> Self:
        """Nothing is loaded."""
        return cls(skill, options)

    def reset(self) -> None:
        """Cold again."""
        self._is_cold = True

    def infer(self, observation: Observation) -> Actions:
        """The rows, when they are due."""
        asked_s = time.monotonic()
        latency_s = self._latency_s * self._rng.uniform(1.0 - self._jitter, 1.0 + self._jitter)
        latency_s *= COLD if self._is_cold else 1.0
        self._is_cold = False
        speed = self._rng.choice(SPEEDS)
        rows = np.zeros((self._rows, self._dim), np.float32)
        rows[:, TURN] = speed
        rows[:, -1] = 1.0  # the gripper stays closed
        if self.continues_rows:
            _lead_over(rows, observation.prefix())
        time.sleep(max(0.0, asked_s + latency_s - time.monotonic()))
        line = {
            "tick": observation.tick, "latency_s": latency_s, "speed": speed,
            "asked_s": asked_s, "answered_s": time.monotonic(),
        }  # fmt: skip
        with self._log.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        return rows


def _lead_over(rows: Actions, prefix: Actions) -> None:
    """What a policy that chunks in real time does: repeat what will act, then go on evenly."""
    if not len(prefix):
        return
    begin = min(len(prefix), len(rows))
    rows[:begin] = prefix[:begin]
    for step, row in enumerate(rows[begin : begin + LEADS_OVER], 1):
        share = step / (LEADS_OVER + 1)
        row[TURN] = (1.0 - share) * prefix[-1, TURN] + share * row[TURN]
