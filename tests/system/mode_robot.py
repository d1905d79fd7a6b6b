"""A running robot that is given one small skill after the other, and what came of each."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from bench.equipment.live_robot import wait_for
from fairlead.messages import (
    FloatArray,
    GoalResult,
    Hold,
    JointState,
    Outcome,
    SafeChunk,
    Verdict,
    decode,
    floats,
)
from fairlead.modes import ControlMode
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.scratch import ScratchRobot

SEED = 0
STALL_S = 20.0


@dataclass(frozen=True)
class ModeSkill:
    """A skill with a policy that always says the same.

    slots: without their ranges, in the policy's order; numbers: what it says for each.
    """

    slots: tuple[dict[str, Any], ...]
    numbers: tuple[tuple[float, ...], ...]
    ticks: int = 8

    def manifest(self, name: str, robot: RobotManifest, state: Mapping[str, Any]) -> dict[str, Any]:
        """``rskill.yaml`` of this skill."""
        ends = np.cumsum([len(numbers) for numbers in self.numbers]).tolist()
        slots = [
            {"range": [end - len(numbers), end - 1], **slot}
            for slot, numbers, end in zip(self.slots, self.numbers, ends, strict=True)
        ]
        row = [float(number) for numbers in self.numbers for number in numbers]
        return {
            "id": name, "version": "0.1.0", "licence": "Apache-2.0", "model_family": "test",
            "policy": {"backend": "constant", "options": {"row": row}},
            "embodiments": [robot.id], "prompt": "move", "state_contract": dict(state),
            "action_contract": {"dim": ends[-1], "slots": slots},
            "rate_hz": 1e9 / robot.tick_period_ns, "horizon": 8, "execute_steps": 4,
            "age_max_ticks": 10, "inference_timeout_s": 5.0,
        }  # fmt: skip


def write_skills(
    folder: Path, skills: Mapping[str, ModeSkill], robot: RobotManifest, state: Mapping[str, Any]
) -> None:
    """One folder a skill."""
    for name, skill in skills.items():
        (folder / name).mkdir(parents=True)
        text = yaml.safe_dump(skill.manifest(name, robot, state))
        (folder / name / "rskill.yaml").write_text(text, encoding="utf-8")


@dataclass
class Story:
    """What happened while one skill ran.

    states: one per tick, from the still robot before to the still robot after.
    released: what the HAL got of the gate. verdicts: what the gate said.
    """

    states: list[JointState] = field(default_factory=list)
    released: list[SafeChunk] = field(default_factory=list)
    verdicts: list[Verdict] = field(default_factory=list)

    @property
    def start(self) -> FloatArray:
        """Measured positions of commanded, then passive joints, before anything moved."""
        return floats(self.states[0].positions)

    @property
    def end(self) -> FloatArray:
        """The same, at rest again."""
        return floats(self.states[-1].positions)

    def acted(self, part: int) -> list[JointState]:
        """States in which ``part`` had just executed a released row."""
        return [state for state in self.states if state.acted[part].hold == Hold.NONE]

    @property
    def refusals(self) -> list[Verdict]:
        return [verdict for verdict in self.verdicts if verdict.outcome == Outcome.REFUSED]

    def row(self, part: int) -> tuple[ControlMode, str, FloatArray, tuple[int, ...]]:
        """Mode, frame, values and mask of a part: the same in every row the HAL got."""
        found = [p for chunk in self.released for p in chunk.parts if p.part == part]
        assert found, "nothing was released"
        width = len(floats(found[0].values)) // self.released[0].horizon
        rows = np.concatenate([floats(p.values, width) for p in found])
        assert (rows == rows[0]).all()
        heads = {(p.mode, p.frame_id, p.active) for p in found}
        [(mode, frame, active)] = heads
        return ControlMode(mode), frame, rows[0], active


class ModeRobot:
    """Runs skills, each in a new episode of the same seed."""

    def __init__(self, robot: ScratchRobot, skills: Mapping[str, ModeSkill]) -> None:
        self._client, self._skills = robot.client, skills
        self._story, self._repeats = Story(), 0
        self._changed = threading.Condition()
        bus, keys = robot.client.bus, robot.client.keys
        bus.subscribe(keys.joints, self._on_joints)
        bus.subscribe(keys.every_safe, self._on_safe)
        bus.subscribe(keys.every_verdict, self._on_verdict)

    def run(self, name: str) -> Story:
        """The skill's goal for its ticks, from a still robot to a still robot."""
        story, result = self._goal(name)
        assert result.outcome == "deadline", result
        return story

    def _goal(self, name: str) -> tuple[Story, GoalResult]:
        self._client.disarm()
        self._client.reset_episode(SEED)
        self._client.arm()
        self._wait_still()
        with self._changed:
            self._story = Story(states=self._story.states[-1:])
        wish = GoalOptions(name, deadline_ticks=self._skills[name].ticks, stall_timeout_s=STALL_S)
        result = run_goal(self._client, wish).result
        assert result is not None
        self._wait_still()
        with self._changed:
            return self._story, result

    def _wait_still(self) -> None:
        """Without a claim a still world repeats its tick; one that moves does not."""
        with self._changed:
            self._repeats = 0
        wait_for(lambda: self._repeats > 0, "the robot stands still")

    def _on_joints(self, sample: Sample) -> None:
        state = decode(JointState, sample.payload)
        with self._changed:
            if self._story.states and state.tick == self._story.states[-1].tick:
                self._repeats += 1
            else:
                self._story.states.append(state)

    def _on_safe(self, sample: Sample) -> None:
        chunk = decode(SafeChunk, sample.payload)
        with self._changed:
            if chunk.verdict_id not in [known.verdict_id for known in self._story.released]:
                self._story.released.append(chunk)

    def _on_verdict(self, sample: Sample) -> None:
        with self._changed:
            self._story.verdicts.append(decode(Verdict, sample.payload))
