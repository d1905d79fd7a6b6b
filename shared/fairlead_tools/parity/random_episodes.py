"""Random vectors through dispatch and the HAL's backend, in one process, without the gate.

The gate refuses most random vectors of full scale, and a held tick is no tick of training. What
lies on both sides of the gate changes none of their bits: that is what these episodes show.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.service_options import check_options
from fairlead.hal.backend import PartCommand
from fairlead.messages import ResetEpisodeReply
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import resolve_routes
from fairlead_tools.parity.deployed_episode import DeployedEpisode
from fairlead_tools.parity.episode_trace import EpisodeTrace
from fairlead_tools.parity.local_episode import commands_of

if TYPE_CHECKING:
    from fairlead_hal_sim import RobosuiteBackend

HELD = 1
"""Ticks held after the reset, as a host does."""


def random_episodes(
    deployment: Deployment, skill: SkillManifest, scale: float, seeds: Iterable[int], ticks: int
) -> list[DeployedEpisode]:
    """For each seed a reset and ``ticks`` vectors of its own, uniform in ``[-scale, scale]``."""
    from fairlead_hal_sim import HalSimOptions, RobosuiteBackend

    robot = load_robot(deployment.robot)
    name = deployment.only("hal_sim")
    options = check_options(deployment, name, HalSimOptions)
    backend = RobosuiteBackend(
        options.model_copy(update={"cameras": ()}), robot.tick_period_ns, robot
    )
    routes = resolve_routes(skill.action_contract, robot)
    from fairlead_skill_runner import TraceRecord, dispatch

    episodes = []
    try:
        for seed in seeds:
            dim = skill.action_contract.dim
            rng = np.random.default_rng(seed)
            rows = rng.uniform(-scale, scale, (ticks, dim)).astype(np.float32)
            trace = EpisodeTrace()
            backend.reset(seed)
            _step(trace, backend, {})
            parts = dispatch(routes, rows, dim)
            for tick in range(ticks):
                _step(trace, backend, commands_of(routes, parts, tick))
            first = 1 + HELD
            reset = ResetEpisodeReply(tick=first, episode_tick=1, held_ticks=HELD)
            call = TraceRecord(first, np.zeros(0), rows)
            episodes.append(DeployedEpisode(seed, trace, reset, [call]))
    finally:
        backend.close()
    return episodes


def _step(trace: EpisodeTrace, backend: RobosuiteBackend, commands: dict[str, PartCommand]) -> None:
    data = backend.env.sim.data
    trace.qpos.append(np.array(data.qpos, dtype="<f8").tobytes())
    trace.qvel.append(np.array(data.qvel, dtype="<f8").tobytes())
    backend.apply(commands)
    assert backend.last_packed is not None
    trace.packed.append(backend.last_packed.tobytes())
    trace.held.append(not commands)
