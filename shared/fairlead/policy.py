"""What a policy is, what it sees, and what it returns: nothing about robots, keys or time.

A policy is a class: in a Python file of a skill's folder, or behind an entry point in
``fairlead.policies``, which a skill then names as its ``backend``. The runner imports it in a
process of its own, only for the skill that names it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, Self

import numpy as np
import numpy.typing as npt
from pydantic import JsonValue

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import SkillManifest

__all__ = [
    "Actions",
    "Done",
    "Executed",
    "Failed",
    "Judged",
    "Observation",
    "Policy",
    "PolicyOfRobot",
    "ServerAddress",
]

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


@dataclass(frozen=True)
class Done:
    """The goal is reached: it succeeds, decided by the policy. reason: for people."""

    reason: str


@dataclass(frozen=True)
class Failed:
    """The goal cannot be reached: it fails, decided by the policy.

    Attributes:
        kind: for programs, in lower case: ``goal_outside_zones``.
        reason: for people.

    Raises:
        ConfigError: for another spelling of ``kind``.
    """

    kind: str
    reason: str

    def __post_init__(self) -> None:
        if not re.fullmatch(r"[a-z][a-z0-9_]{0,63}", self.kind):
            form = "1 to 64 of a-z 0-9 _ starting with a letter"
            raise ConfigError(expected("policy: Failed: kind", form, repr(self.kind)))


class ServerAddress(NamedTuple):
    """How the address of a policy's server is written.

    pattern: a regular expression for the whole address. example: one that fits.
    """

    pattern: str
    example: str


class Policy(Protocol):
    """A policy.

    Besides its methods its class may have:

    ``check_options(skill, options)``: a class method that raises `ConfigError` for options that
    do not fit, without loading anything; ``fairlead skill check`` and ``install`` call it.

    ``server_address``: a `ServerAddress` if the policy is behind a server. A deployment file may
    then say where that is, which replaces the option ``address``.
    """

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Load and warm up the policy (once, in the worker process, before any claim).

        Raises:
            ConfigError: for options that do not fit.
        """

    def infer(self, observation: Observation) -> Actions | Done | Failed:
        """Rows for ``observation.tick`` and the ticks after it: float32 ``[H, dim]``.

        Other floats, float64 above all, are rounded to float32, to one part in 16 million.

        `Done` and `Failed` end the goal instead; what was released before may still act
        until the claim has been given back, then the parts hold.
        """

    def reset(self) -> None:
        """Forget the last episode; called at the start of every goal."""


class PolicyOfRobot(Protocol):
    """What a class may have instead of `Policy.from_options`, for one that plans.

    It also gets the robot it drives and the name of the safety profile that holds, so that it can
    keep to its zones.
    """

    @classmethod
    def for_robot(
        cls,
        skill: SkillManifest,
        options: Mapping[str, JsonValue],
        robot: RobotManifest,
        profile: str,
    ) -> Policy:
        """As `Policy.from_options`."""
