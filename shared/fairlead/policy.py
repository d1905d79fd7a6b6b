"""What a policy is, what it sees, and what it returns: nothing about robots, keys or time.

A policy is a class: in a Python file of a skill's folder, or behind an entry point in
``fairlead.policies``, which a skill then names as its ``backend``. The runner imports it in a
process of its own, only for the skill that names it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import takewhile
from typing import Any, NamedTuple, Protocol, Self

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
    "PastAnswer",
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
class PastAnswer:
    """One of the newest answers of this goal, and what became of each of its rows.

    A row for which nothing is set was too late, was never proposed (lockstep: rows beyond
    ``execute_steps``), was replaced by a newer answer, or waits for the gate's verdict.

    tick: `Observation.tick` of the observation it answered; row i is for the ``periods`` control
        periods from ``tick + i * periods``, and masks are as of those, also where a ``seam`` made
        targets come later after a hold.
    rows: float32 ``[H, dim]``, as the policy returned them.
    periods: control periods for one row.
    outcome: the gate's newest word: ``released``, ``truncated``, ``refused``; "": none yet.
    acted: bool ``[H]``: a part executed the row.
    refused: bool ``[H]``: the gate refused it, or took it back before it acted.
    to_act: bool ``[H]``: released; it acts from `Observation.tick` on, unless a newer answer
        replaces it.
    """

    tick: int
    rows: Actions
    periods: int
    outcome: str
    acted: npt.NDArray[np.bool_]
    refused: npt.NDArray[np.bool_]
    to_act: npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Observation:
    """What a policy sees; its arrays are read-only.

    tick: the joint state's tick (control periods).
    state: the layout vector, float64, shape ``[state_contract.dim]``, SI.
    prompt: the instruction.
    images: by the policy's picture name, as the skill declares it; without a word of that uint8
        ``[height, width, 3]``, RGB, row 0 at the top.
    executed: by the name of each part that the skill commands, what it did in the period
        before; empty where the robot's report of that period was lost.
    judged: the gate's newest word on an answer of this goal; None before the first.
    frames: by the name of each picture with several ``deltas``, ``[T, ...]`` of these arrays,
        oldest first; the last is the one in ``images``.
    answers: the newest answers of this goal, oldest first, with what became of their rows.
    delay_ticks: control periods from an observation to the first row of its answer that can act,
        as it was the last time; 1 before that.
    earlier: the state at the ``deltas`` of the state contract before 0, ``[T - 1, dim]``.
    periods: control periods for one row.
    """

    tick: int
    state: FloatArray
    prompt: str
    images: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    executed: Mapping[str, Executed] = field(default_factory=dict)
    judged: Judged | None = None
    frames: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    answers: tuple[PastAnswer, ...] = ()
    delay_ticks: int = 1
    earlier: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    periods: int = 1

    @property
    def states(self) -> FloatArray:
        """The state at all its deltas, float64 ``[T, dim]``, oldest first."""
        return np.concatenate([self.earlier.reshape(-1, len(self.state)), self.state[None]])

    def frames_of(self, name: str) -> npt.NDArray[Any]:
        """One picture at all its deltas, ``[T, ...]``, oldest first."""
        frames = self.frames.get(name)
        return self.images[name][None] if frames is None else frames

    def rows_to_act(self) -> Actions:
        """Released rows that have not acted yet, in the order of their ticks: ``[n, dim]``.

        The first is for the control period of this observation, if there is one for it: what a
        policy that chunks in real time continues.
        """
        left = [answer.rows[answer.to_act] for answer in self.answers]
        return np.concatenate(left) if left else np.zeros((0, 0), np.float32)

    def prefix(self) -> Actions:
        """Rows that act from this control period on, before the answer can: ``[n, dim]``.

        ``delay_ticks`` control periods of them and one more, so that an answer a period later than
        those before makes no step; fewer where rows run out before. An answer that waits for its
        verdict counts as released, from the next period on. An answer's first n rows are too late,
        so a policy that chunks in real time repeats these and goes on.
        """
        ticks = range(self.tick, self.tick + self.delay_ticks + 1, self.periods)
        rows = list(takewhile(lambda row: row is not None, map(self._row_at, ticks)))
        return np.array(rows, np.float32) if rows else np.zeros((0, 0), np.float32)

    def _row_at(self, tick: int) -> Actions | None:
        """The one that acts in a control period, as far as is known."""
        for answer in reversed(self.answers):
            row = (tick - answer.tick) // answer.periods
            if 0 <= row < len(answer.rows) and (
                answer.to_act[row] or (not answer.outcome and tick > self.tick)
            ):
                acts: Actions = answer.rows[row]
                return acts
        return None


@dataclass(frozen=True)
class Done:
    """The goal is reached: it succeeds, decided by the policy. reason: for people."""

    reason: str


FAILURE_KIND = r"[a-z][a-z0-9_]{0,63}"
"""How a kind of failure is written, as a regular expression."""


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
        if not re.fullmatch(FAILURE_KIND, self.kind):
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

    ``check_files(skill, options, folder)``: the same for the files of the skill's folder.

    ``server_address``: a `ServerAddress` if the policy is behind a server. A deployment file may
    then say where that is, which replaces the option ``address``.

    ``takes_states``: True if it reads `Observation.states`. Another is refused a skill that wants
    earlier states.

    ``continues_rows``: True if its answers go on from `Observation.prefix` (real-time chunking). A
    skill that blends their seam as well is refused.

    ``probe``: False if ``infer`` does more than answer; else a package's policy is asked once as
    it is loaded, with a state of 0.5 everywhere and black pictures.
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
        """Forget the last episode; called at the start of every goal, and of a probe at load."""


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
