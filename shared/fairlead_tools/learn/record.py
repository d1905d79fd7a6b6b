"""Episodes in one process, with the HAL's simulator, the assembler and the policy, without a gate.

`fairlead parity` proves that a deployed episode does the same to the last bit while nothing of it
is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.service_options import check_options
from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.policy import Actions, Done, Failed, Observation
from fairlead.robot.manifest import load_robot
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import resolve_routes
from fairlead_tools.learn.dataset import NO_LABELS, Episode
from fairlead_tools.parity.local_episode import (
    asked,
    commands_of,
    make_policy,
    observe,
    raising,
    require_each_period,
)
from fairlead_tools.parity.local_eyes import LocalEyes

if TYPE_CHECKING:
    from fairlead_hal_sim import RobosuiteBackend

WHO = "dataset record"
SWITCHES = ("gripper_position", "gripper_binary", "composite_mode")
"""What noise leaves alone."""

_PROBES = 4

LESS = 0.12 / 0.35
"""Of what a tool's translation gets, what turns and bases get: more, and the expert fails."""


@dataclass(frozen=True)
class Teacher:
    """An expert without memory, which says in each tick what it would do.

    beta: share of the answers that act which are the expert's, drawn with the seed; as in DAgger.
    """

    skill: SkillManifest
    beta: float = 1.0


def record(
    deployment: Deployment,
    skill: SkillManifest,
    seeds: Iterable[int],
    noise: float,
    most_ticks: int,
    on_tick: Callable[[int, int], None],
    teacher: Teacher | None = None,
) -> Generator[Episode, None, None]:
    """Run the skill once in a new episode of each seed.

    Args:
        noise: standard deviation, as a share of full scale, of what is added to the numbers of an
            answer, the same for all its rows; each episode has up to this, drawn with its seed.
        on_tick: told of seed and tick.
        teacher: with a beta of 1 the skill's own policy is not asked, and need not be there.

    Raises:
        ConfigError: rows are not the simulator's own steps or not the expert's, a camera that the
            skill wants is missing.
        PolicyError: as `asked`.
    """
    from fairlead_hal_sim import HalSimOptions, RobosuiteBackend

    robot = load_robot(deployment.robot)
    require_each_period(WHO, skill, robot)
    if teacher is not None and not _same_rows(teacher.skill, skill):
        raise ConfigError(
            expected(f"dataset record: expert {teacher.skill.id}", "rate, horizon and "
                     f"action_contract of {skill.id}", "others")
        )  # fmt: skip
    hal = deployment.only("hal_sim")
    options = check_options(deployment, hal, HalSimOptions)
    with (
        closing(LocalEyes(options, robot, skill)) as eyes,
        closing(RobosuiteBackend(options, robot.tick_period_ns, robot)) as backend,
    ):
        run = _Runs(deployment, skill, backend, eyes, teacher)
        for seed in seeds:
            yield run.episode(seed, noise, most_ticks, on_tick)


def _same_rows(one: SkillManifest, other: SkillManifest) -> bool:
    first, second = ((s.rate_hz, s.horizon, s.action_contract) for s in (one, other))
    return first == second


def _require_rows(seed: int, ticks: int, end: Done | Failed) -> None:
    if ticks == 0:
        said = f"the policy ended before its first row: {end.reason}"
        raise PolicyError(f"dataset record: seed {seed}: {said}")


class _Runs:
    """Episodes on one simulator, one after the other."""

    def __init__(
        self,
        deployment: Deployment,
        skill: SkillManifest,
        backend: RobosuiteBackend,
        eyes: LocalEyes,
        teacher: Teacher | None,
    ) -> None:
        from fairlead_state_assembler import LocalAssembler

        robot = load_robot(deployment.robot)
        self._skill, self._backend, self._eyes = skill, backend, eyes
        self._assembler, self._teacher = LocalAssembler(robot), teacher
        self._expert = make_policy(WHO, teacher.skill) if teacher else None
        acts = teacher is None or teacher.beta < 1
        self._policy = make_policy(WHO, skill) if acts else None
        self._routes = resolve_routes(skill.action_contract, robot)
        self._unused = [
            index
            for slot in skill.action_contract.slots or ()
            if slot.discard
            for index in range(slot.first, slot.last + 1)
        ]
        self._is_same_vector = False

    def episode(
        self, seed: int, noise: float, most_ticks: int, on_tick: Callable[[int, int], None]
    ) -> Episode:
        """From a reset to success, the policy's end or ``most_ticks``."""
        from fairlead_skill_runner import fitted, pixels_of

        rng = np.random.default_rng(seed)
        scale = noise * rng.uniform() * _noisy(self._skill.action_contract)
        self._begin(seed)
        seen: list[Observation] = []
        labels: list[Actions] = []
        said: list[Actions] = []
        acted: list[Actions] = []
        rows: Actions = np.zeros((0, 0), np.float32)
        given, index = rows, 0
        succeeded = False
        while len(seen) < most_ticks and not succeeded:
            observation, label = self._see(len(seen) + 1)
            if index >= min(len(rows), self._skill.execute_steps):
                answer = self._answer(observation, label, rng)
                if isinstance(answer, Done | Failed):
                    _require_rows(seed, len(seen), answer)
                    break
                rows, index = answer, 0
                added = scale * rng.standard_normal(len(scale))
                given = fitted(self._routes, np.clip(rows + added, -1, 1).astype(np.float32)
                               if noise else rows).copy()  # fmt: skip
                given[:, self._unused] = 0.0
            seen.append(observation)
            labels += [] if label is None else [label]
            said.append(rows[index])
            acted.append(given[index].copy())
            self._backend.env.step(given[index].copy())  # turns the base's numbers in place
            index += 1
            task = self._backend.task()
            succeeded = task is not None and task.success
            on_tick(seed, len(seen))
        pictures = {
            name: pixels_of(spec, np.array([one.images[name] for one in seen]))
            for name, spec in self._skill.images.items()
        }
        return Episode(seed, succeeded, np.array([o.state for o in seen]), np.array(said),
                       np.array(acted), pictures, np.array(labels or NO_LABELS))  # fmt: skip

    def _begin(self, seed: int) -> None:
        """Reset all; a host holds one tick then."""
        for policy in (self._policy, self._expert):
            if policy is not None:
                with raising(f"{WHO}: seed {seed}: reset failed"):
                    policy.reset()
        self._eyes.begin(1)  # the held tick is none of the episode, as in a host
        self._backend.reset(seed)
        self._backend.apply({})
        if not self._is_same_vector:
            self._check_vector()
            self._is_same_vector = True

    def _check_vector(self) -> None:
        """Whether the skill's rows are the numbers that the simulator takes, as a HAL packs them.

        Raises:
            ConfigError: a part is left out, or a slot has another place, scale or mode.
        """
        from fairlead_skill_runner import dispatch, fitted

        contract, backend = self._skill.action_contract, self._backend
        shape = (_PROBES, contract.dim)
        rows = np.random.default_rng(0).uniform(-1, 1, shape).astype(np.float32)
        rows = fitted(self._routes, rows).copy()
        rows[:, self._unused] = 0.0
        found = backend.describe().parts
        offered = {part.name: {one.mode for one in part.ranges} for part in found}
        parts = dispatch(self._routes, rows, contract.dim)
        problem = ", ".join(
            f"{route.part_name} {route.mode.yaml_name}"
            for route in self._routes
            if int(route.mode) not in offered[route.part_name]
        )
        if not problem:
            packed = [backend.pack(commands_of(self._routes, parts, row)) for row in range(_PROBES)]
            if packed[0].shape == (contract.dim,) and np.array_equal(np.array(packed), rows):
                return
        raise ConfigError(
            f"dataset record: skill {self._skill.id}: expected rows that are the simulator's own "
            f"vector of {len(backend.pack({}))} numbers, in its order and scale, for every part; "
            f"got others{f': the HAL does not offer {problem}' if problem else ''}"
        )

    def _see(self, tick: int) -> tuple[Observation, Actions | None]:
        """What the policy sees in a tick, and the expert's answer there."""
        state = observe(self._assembler, self._backend, self._skill)
        self._eyes.look(tick, self._backend)
        observation = self._eyes.observation(tick, state)
        if self._expert is None or self._teacher is None:
            return observation, None
        contract = self._teacher.skill.state_contract
        known = Observation(tick, self._assembler.assemble(contract), self._skill.prompt)
        rows = asked(WHO, self._expert, self._teacher.skill, known)
        if isinstance(rows, Done | Failed) or len(rows) != self._skill.horizon:
            got = type(rows).__name__ if isinstance(rows, Done | Failed) else f"{len(rows)} rows"
            who, wanted = f"expert {self._teacher.skill.id}", f"{self._skill.horizon} rows"
            raise ConfigError(expected(f"dataset record: {who}", wanted, got))
        return observation, rows

    def _answer(
        self, observation: Observation, label: Actions | None, rng: np.random.Generator
    ) -> Actions | Done | Failed:
        if self._teacher is not None and label is not None and rng.uniform() < self._teacher.beta:
            return label
        assert self._policy is not None, "made unless the expert always acts"
        return asked(WHO, self._policy, self._skill, observation)


def _noisy(contract: ActionContract) -> npt.NDArray[np.float64]:
    """The share of `record`'s noise that each number gets; 0.0 for switches."""
    shares = np.zeros(contract.dim)
    for slot in contract.routed:
        if slot.control_mode not in SWITCHES:
            shares[slot.first : slot.last + 1] = LESS
        if slot.control_mode == "cartesian_delta":
            shares[slot.first : slot.first + 3] = 1.0
    return shares
