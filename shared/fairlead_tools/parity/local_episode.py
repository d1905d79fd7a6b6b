"""The same episode in one process: the policy's vectors straight into ``env.step``."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from traceback import print_exc
from typing import TYPE_CHECKING, Any

import numpy as np

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.service_options import check_options
from fairlead.errors import ConfigError, FairleadError, PolicyError, expected
from fairlead.hal.backend import Backend, PartCommand
from fairlead.messages import ActionPart, ResetEpisodeReply, floats
from fairlead.policy import Actions, Done, Failed, Observation
from fairlead.reason_text import reason_of
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.deltas import NOW
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import Route, resolve_routes
from fairlead_tools.parity.episode_trace import EpisodeTrace
from fairlead_tools.parity.local_eyes import LocalEyes

if TYPE_CHECKING:
    from fairlead.policy import Policy
    from fairlead_hal_sim import RobosuiteBackend
    from fairlead_state_assembler import LocalAssembler


class LocalEpisode:
    """One episode: reset, held as long as the deployed reset did, then an answer at a time.

    The policy is the one that the deployment's runner has for the skill.

    The vector goes to the simulator as the policy wrote it, but for its slots' clips and
    thresholds: the deployment's ``part_order`` is the policy's own.

    Args:
        reset: how the deployed reset went; its held ticks are repeated here.

    Attributes:
        trace: what has been computed so far.
    """

    def __init__(
        self, deployment: Deployment, skill: SkillManifest, seed: int, reset: ResetEpisodeReply
    ) -> None:
        from fairlead_hal_sim import HalSimOptions, RobosuiteBackend
        from fairlead_skill_runner import RunnerOptions
        from fairlead_state_assembler import LocalAssembler

        robot = load_robot(deployment.robot)
        hal = deployment.only("hal_sim")
        options = check_options(deployment, hal, HalSimOptions)
        self._skill, self._first_tick = skill, reset.tick - reset.held_ticks
        runner = check_options(deployment, deployment.only("skill_runner"), RunnerOptions)
        deployed = skill.model_copy(update={"policy": runner.policy(skill)})
        self._assembler, self._policy = LocalAssembler(robot), make_policy("parity", deployed)
        self._routes = resolve_routes(skill.action_contract, robot)
        self._backend = RobosuiteBackend(options, robot.tick_period_ns, robot)
        self.trace = EpisodeTrace()
        try:
            self._eyes = LocalEyes(options, robot, skill)
        except BaseException:
            self._backend.close()
            raise
        try:
            self._eyes.begin(reset.episode_tick)
            self._backend.reset(seed)
            self._hold(reset.held_ticks)
        except BaseException:
            self.close()
            raise

    @property
    def succeeded(self) -> bool:
        """What the task says now."""
        task = self._backend.task()
        return task is not None and task.success

    def act(self) -> bool:
        """Observe, infer, and step as many rows as the skill executes; False: the policy is done.

        A deployed goal ends at the same tick.
        """
        from fairlead_skill_runner import fitted, picture_hashes

        state = observe(self._assembler, self._backend, self._skill)
        self._eyes.look(self._tick, self._backend)
        seen = self._eyes.observation(self._tick, state)
        actions = asked("parity", self._policy, self._skill, seen)
        if isinstance(actions, Done | Failed):
            return False
        sent = fitted(self._routes, actions)
        self.trace.observations.append(state.astype("<f8").tobytes())
        self.trace.pictures.append(json.dumps(picture_hashes(seen), sort_keys=True).encode())
        self.trace.actions.append(sent.tobytes())
        for index, row in enumerate(sent[: self._skill.execute_steps]):
            if index:  # the first tick's frames and state are there
                self._eyes.look(self._tick, self._backend)
                if self._skill.state_contract.deltas != NOW:
                    state = observe(self._assembler, self._backend, self._skill)
                    self._eyes.feel(self._tick, state)
            _note_state(self.trace, self._backend)
            vector = np.array(row, dtype=np.float32)
            self.trace.packed.append(vector.tobytes())
            self._backend.env.step(vector)  # turns the base's numbers in place: ours to lose
        return True

    def close(self) -> None:
        """Free the simulator, end its camera process."""
        self._eyes.close()
        self._backend.close()

    @property
    def _tick(self) -> int:
        return self._first_tick + len(self.trace.packed)

    def _hold(self, ticks: int) -> None:
        """What the host does until the robot stands still after a reset."""
        for _ in range(ticks):
            self._eyes.look(self._tick, self._backend)
            _note_state(self.trace, self._backend)
            self._backend.apply({})
            assert self._backend.last_packed is not None
            self.trace.packed.append(self._backend.last_packed.tobytes())


def local_episode(
    deployment: Deployment,
    skill: SkillManifest,
    seed: int,
    reset: ResetEpisodeReply,
    most_ticks: int,
) -> EpisodeTrace:
    """A whole `LocalEpisode`.

    Args:
        most_ticks: stop after so many steps, held ones included.
    """
    with closing(LocalEpisode(deployment, skill, seed, reset)) as episode:
        while len(episode.trace.packed) < most_ticks and not episode.succeeded and episode.act():
            pass
        episode.trace.succeeded = episode.succeeded
        return episode.trace


def require_each_period(who: str, skill: SkillManifest, robot: RobotManifest) -> None:
    """Raises `ConfigError` where a row is not for one control period, a step of the simulator."""
    if skill.control_periods(robot.tick_period_ns) != 1:
        wanted, got = "a row for each control period", f"{skill.rate_hz:g} rows/s"
        raise ConfigError(expected(f"{who}: skill {skill.id}", wanted, got))


def make_policy(who: str, skill: SkillManifest) -> Policy:
    """The skill's policy in this process, reset.

    Args:
        who: the command that asks, as errors begin.

    Raises:
        ConfigError, PolicyError: it cannot be loaded, or not be reset.
    """
    from fairlead_skill_runner import served_policy

    with raising(f"{who}: skill {skill.id}: loading failed"):
        policy = served_policy(skill)
    with raising(f"{who}: skill {skill.id}: reset failed"):
        policy.reset()
    return policy


def asked(
    who: str, policy: Policy, skill: SkillManifest, observation: Observation
) -> Actions | Done | Failed:
    """What a policy says, checked as a deployment does, in an array of our own.

    Raises:
        PolicyError: it fails, or says anything but rows of finite numbers.
    """
    from fairlead_skill_runner import policy_rows

    with raising(f"{who}: skill {skill.id}: infer failed in tick {observation.tick}"):
        said = policy.infer(observation)
        if isinstance(said, Done | Failed):
            return said
        return policy_rows(said, skill.action_contract.dim, skill.horizon).copy()


@contextmanager
def raising(who: str) -> Iterator[None]:
    """Whatever a policy raises is a `PolicyError`, with its traceback printed."""
    try:
        yield
    except FairleadError:
        raise
    except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever a policy raises
        print_exc()
        raise PolicyError(f"{who}: {reason_of(error)}") from None


def observe(
    assembler: LocalAssembler, backend: Backend, skill: SkillManifest
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The skill's layout vector as the simulator stands, float64 ``[dim]``."""
    measured = backend.read()
    assembler.take(
        measured.positions,
        backend.transforms(),
        backend.static_transforms(),
        measured.velocities,
    )
    return assembler.assemble(skill.state_contract)


def commands_of(
    routes: Sequence[Route], parts: Sequence[ActionPart], row: int
) -> dict[str, PartCommand]:
    """One row of a chunk, as the HAL gets it."""
    return {
        route.part_name: PartCommand(
            route.mode, part.frame_id, floats(part.values, route.width)[row], part.active
        )
        for route, part in zip(routes, parts, strict=True)
    }


def _note_state(episode: EpisodeTrace, backend: RobosuiteBackend) -> None:
    data = backend.env.sim.data
    episode.qpos.append(np.array(data.qpos, dtype="<f8").tobytes())
    episode.qvel.append(np.array(data.qvel, dtype="<f8").tobytes())
