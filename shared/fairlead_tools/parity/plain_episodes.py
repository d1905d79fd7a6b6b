"""Deployed episodes again in plain robosuite: the policy's raw vectors, no HAL, no services."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.service_options import check_options
from fairlead.errors import ConfigError, ServiceError, expected
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import resolve_routes
from fairlead_tools.parity.deployed_episode import DeployedEpisode
from fairlead_tools.parity.episode_trace import Comparison, EpisodeTrace, compare

QUANTITIES = ("packed", "qpos", "qvel")
_SCENE = "fairlead_hal_sim.task"  # registers the environment that ships
_TIMEOUT_S = 600.0  # for each episode
_LAST_LINES = 3


@dataclass(frozen=True)
class PlainComparison:
    """One deployed episode beside plain robosuite.

    rows: up to the first held tick. compared: rows of the policy until there.
    ticks: of the episode, after its reset.
    held: ticks inside the episode in which a part held, which training does not know.
    apart: largest difference of any number of qpos at the episode's end, plain robosuite having
    been given the same vectors: 0.0 unless a tick was held.
    """

    seed: int
    rows: list[Comparison]
    ticks: int
    compared: int
    held: int
    apart: float

    @property
    def same(self) -> bool:
        """Whether everything compared is equal to the last bit."""
        return all(row.same for row in self.rows)


def check_comparable(deployment: Deployment, skill: SkillManifest) -> None:
    """Before anything starts: whether there is a plain loop to compare with.

    Raises:
        ConfigError: no robosuite behind this deployment, or the skill's output is not the
            vector that its simulator takes.
    """
    runs = (spec.run for spec in deployment.services.values())
    kinds = [run for run in runs if run.startswith("hal")]
    if "hal_sim" not in kinds:
        raise ConfigError(expected("parity", "a deployment that runs hal_sim (robosuite)", kinds))
    robot = load_robot(deployment.robot)
    told = [route.part_name for route in resolve_routes(skill.action_contract, robot)]
    left_out = [part for part in robot.part_names if part not in told]
    if left_out:
        raise ConfigError(
            f"parity: skill {skill.id} tells {', '.join(told)} of {robot.id} and leaves out "
            f"{', '.join(left_out)}: its {skill.action_contract.dim} numbers are not the vector "
            "that this simulator takes, so there is no loop of env.step to compare with"
        )


def compare_with_plain(
    deployment: Deployment, skill: SkillManifest, deployed: Sequence[DeployedEpisode]
) -> list[PlainComparison]:
    """Each episode beside its own in plain robosuite.

    Raises:
        ServiceError: the process of the plain loop failed, with its last lines.
    """
    robot = load_robot(deployment.robot)
    jobs = [_job(one, skill) for one in deployed]
    found = _run(_environment(deployment, robot) | {"episodes": jobs})
    return [
        _beside(one, _trace(plain)) for one, plain in zip(deployed, found["episodes"], strict=True)
    ]


def _environment(deployment: Deployment, robot: RobotManifest) -> dict[str, Any]:
    from fairlead_hal_sim import HalSimOptions

    name = deployment.only("hal_sim")
    options = check_options(deployment, name, HalSimOptions)
    order = options.part_order
    return {
        "env": options.env,
        "robot": options.robot,
        "controller": options.controller,
        "part_order": None if order is None else list(order),
        "imports": [_SCENE, *options.imports],
        "env_options": options.env_options,
        "control_hz": 1e9 / robot.tick_period_ns,
    }


def _job(one: DeployedEpisode, skill: SkillManifest) -> dict[str, Any]:
    """What the plain loop steps: the policy's rows, and what the HAL packed where it held."""
    discarded = [
        index
        for slot in skill.action_contract.slots or ()
        if slot.discard
        for index in range(slot.first, slot.last + 1)
    ]
    vectors = []
    for tick in range(one.reset.held_ticks, len(one.trace.packed)):
        if one.trace.held[tick]:
            vectors.append(one.trace.packed[tick].hex())
            continue
        row = one.raw_row(tick)
        row[discarded] = 0.0
        vectors.append(row.tobytes().hex())
    return {"seed": one.seed, "zeros": one.reset.held_ticks, "vectors": vectors}


def _run(job: dict[str, Any]) -> dict[str, Any]:
    script = Path(__file__).with_name("plain_robosuite.py")
    timeout_s = _TIMEOUT_S * len(job["episodes"])
    try:
        done = subprocess.run(
            [sys.executable, str(script)],
            input=json.dumps(job),
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise ServiceError(f"parity: plain robosuite took longer than {timeout_s:g} s") from None
    if done.returncode != 0:
        last = "; ".join(done.stderr.strip().splitlines()[-_LAST_LINES:])
        raise ServiceError(f"parity: plain robosuite ended with {done.returncode}: {last}")
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def _trace(found: dict[str, list[str]]) -> EpisodeTrace:
    packed, qpos, qvel = ([bytes.fromhex(one) for one in found[name]] for name in QUANTITIES)
    return EpisodeTrace(packed=packed, qpos=qpos, qvel=qvel)


def _beside(one: DeployedEpisode, plain: EpisodeTrace) -> PlainComparison:
    ticks, resets = len(one.trace.packed), one.reset.held_ticks
    inside = one.trace.held[resets:]
    until = resets + (inside.index(True) if True in inside else len(inside))
    rows = compare(one.trace.until(until), plain.until(until), QUANTITIES)
    apart = np.abs(
        np.frombuffer(one.trace.qpos[ticks - 1], "<f8")
        - np.frombuffer(plain.qpos[ticks - 1], "<f8")
    )
    held, far = sum(inside), float(apart.max())
    return PlainComparison(one.seed, rows, ticks - resets, until - resets, held, far)
