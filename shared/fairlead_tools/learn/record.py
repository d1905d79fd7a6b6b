"""Episodes in one process, with the HAL's simulator, the assembler and the policy, without a gate.

`fairlead parity` proves that a deployed episode does the same to the last bit while nothing of it
is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.policy import Actions, Done, Failed, Observation
from fairlead.robot.manifest import load_robot
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import resolve_routes
from fairlead_tools.learn.dataset import Episode
from fairlead_tools.parity.local_episode import make_policy, observe

if TYPE_CHECKING:
    from fairlead.policy import Policy
    from fairlead_hal_sim import RobosuiteBackend
    from fairlead_state_assembler import LocalAssembler

SWITCHES = ("gripper_position", "gripper_binary", "composite_mode")
"""What noise leaves alone."""

LESS = 0.12 / 0.35
"""Of what a tool's translation gets, what turns and bases get: more, and the expert fails."""


def record(
    deployment: Deployment,
    skill: SkillManifest,
    seeds: Iterable[int],
    noise: float,
    most_ticks: int,
    on_tick: Callable[[int, int], None],
) -> Iterator[Episode]:
    """Run the skill once in a new episode of each seed.

    Args:
        noise: standard deviation, as a share of full scale, of what is added to the numbers of an
            answer, the same for all its rows; each episode has up to this, drawn with its seed.
        on_tick: told of seed and tick.

    Raises:
        ConfigError: the skill has pictures, or its rows are not the simulator's steps.
    """
    from fairlead_hal_sim import RobosuiteBackend, read_options
    from fairlead_state_assembler import LocalAssembler

    robot = load_robot(deployment.robot)
    if skill.images or skill.control_periods(robot.tick_period_ns) != 1:
        raise ConfigError(
            expected(f"dataset record: skill {skill.id}", "no pictures and a row for each control "
                     "period", f"{len(skill.images)} pictures, {skill.rate_hz:g} rows/s")
        )  # fmt: skip
    hal = deployment.only("hal_sim")
    options = read_options(hal, deployment.services[hal].options)
    backend = RobosuiteBackend(options.model_copy(update={"cameras": ()}), robot.tick_period_ns)
    try:
        run = _Runs(deployment, skill, backend, LocalAssembler(robot), make_policy(skill))
        for seed in seeds:
            yield run.episode(seed, noise, most_ticks, on_tick)
    finally:
        backend.close()


class _Runs:
    """Episodes on one simulator, one after the other."""

    def __init__(
        self,
        deployment: Deployment,
        skill: SkillManifest,
        backend: RobosuiteBackend,
        assembler: LocalAssembler,
        policy: Policy,
    ) -> None:
        self._skill, self._backend = skill, backend
        self._assembler, self._policy = assembler, policy
        self._routes = resolve_routes(skill.action_contract, load_robot(deployment.robot))

    def episode(
        self, seed: int, noise: float, most_ticks: int, on_tick: Callable[[int, int], None]
    ) -> Episode:
        """From a reset to success, the policy's end or ``most_ticks``."""
        from fairlead_skill_runner import fitted

        rng = np.random.default_rng(seed)
        scale = noise * rng.uniform() * _noisy(self._skill.action_contract)
        self._policy.reset()
        self._backend.reset(seed)
        self._backend.apply({})  # a host holds one tick
        states: list[FloatArray] = []
        said: list[Actions] = []
        acted: list[Actions] = []
        rows: Actions = np.zeros((0, 0), np.float32)
        given, index = rows, 0
        succeeded = False
        while len(states) < most_ticks and not succeeded:
            state = observe(self._assembler, self._backend, self._skill)
            if index >= min(len(rows), self._skill.execute_steps):
                answer = self._policy.infer(Observation(len(states) + 1, state, self._skill.prompt))
                if isinstance(answer, Done | Failed):
                    break
                rows, index = answer, 0
                added = scale * rng.standard_normal(len(scale))
                given = fitted(self._routes, np.clip(rows + added, -1, 1).astype(np.float32)
                               if noise else rows)  # fmt: skip
            states.append(state)
            said.append(rows[index])
            acted.append(given[index].copy())
            self._backend.env.step(given[index].copy())  # turns the base's numbers in place
            index += 1
            task = self._backend.task()
            succeeded = task is not None and task.success
            on_tick(seed, len(states))
        return Episode(seed, succeeded, np.array(states), np.array(said), np.array(acted))


def _noisy(contract: ActionContract) -> npt.NDArray[np.float64]:
    """The share of `record`'s noise that each number gets; 0.0 for switches."""
    shares = np.zeros(contract.dim)
    for slot in contract.routed:
        if slot.control_mode not in SWITCHES:
            shares[slot.first : slot.last + 1] = LESS
        if slot.control_mode == "cartesian_delta":
            shares[slot.first : slot.first + 3] = 1.0
    return shares
