"""What a policy is: two methods, and nothing about robots, keys or time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol, Self

import numpy as np
import numpy.typing as npt
from pydantic import JsonValue

from fairlead.messages import FloatArray
from fairlead.policy import Done, Failed
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import SkillManifest

Actions = npt.NDArray[np.float32]
"""A policy's raw output: shape ``[H, dim]``, 1 <= H <= the skill's horizon."""


@dataclass(frozen=True)
class Executed:
    """What one part did in the control period before an observation.

    hold: "" if it executed a row, else why it held: ``no_row``, ``refused``, ``not_granted``,
        or another name of `fairlead.messages.Hold`, in lower case.
    answer_tick: `Observation.tick` of the answer whose row it executed, row
        ``observation.tick - 1 - answer_tick`` of it; None: it held, or the gate's word on
        that answer was lost.
    """

    hold: str
    answer_tick: int | None


@dataclass(frozen=True)
class Judged:
    """The gate's newest word on an answer of this goal.

    answer_tick: `Observation.tick` of that answer.
    outcome: ``released``, ``truncated`` (its first rows only) or ``refused``.
    code, text: why not all of it, for example ``G021`` and the value beside its limit; "" for
        ``released``.
    last_tick: of its last row that was released; 0: none was.
    """

    answer_tick: int
    outcome: str
    code: str
    text: str
    last_tick: int


@dataclass(frozen=True)
class Observation:
    """What a policy sees.

    tick: the joint state's tick (control periods).
    state: the layout vector, float64, shape ``[state_contract.dim]``, SI.
    prompt: the instruction.
    images: by the policy's picture name, uint8 ``[height, width, 3]``, row 0 at the top.
    executed: by the name of each part that the skill commands, what it did in the period
        before; empty where the robot's report of that period was lost.
    judged: the gate's newest word on an answer of this goal; None before the first.
    """

    tick: int
    state: FloatArray
    prompt: str
    images: Mapping[str, npt.NDArray[np.uint8]] = field(default_factory=dict)
    executed: Mapping[str, Executed] = field(default_factory=dict)
    judged: Judged | None = None


class Policy(Protocol):
    """A policy, or a wrapper around one."""

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Load and warm up the policy (once, in the worker process, before any claim).

        Raises:
            ConfigError: for options that do not fit.
        """

    def infer(self, observation: Observation) -> Actions | Done | Failed:
        """Rows for ``observation.tick`` and the ticks after it: float32 ``[H, dim]``.

        `Done` and `Failed` end the goal instead; what was released before may still act
        until the claim has been given back, then the parts hold.
        """

    def reset(self) -> None:
        """Forget the last episode; called at the start of every goal."""


PlannerMaker = Callable[[SkillManifest, Mapping[str, JsonValue], RobotManifest, str], Policy]
"""``for_robot``, which a class may have instead of ``from_options``: it also gets the robot it
drives and the name of the safety profile that holds, for a planner that keeps to its zones."""
