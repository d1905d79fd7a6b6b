"""Episodes through the deployed services: what the gate released is recorded beside what was said.

States and pictures are those that the runner heard, rows are from its trace, and what acted is from
the HAL's.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.service_options import check_options
from fairlead.errors import ConfigError, ServiceError
from fairlead.messages import Image, LayoutState, decode
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_hearing import Progress
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.policy import Actions, Observation
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import resolve_routes
from fairlead.wire.bus import Sample
from fairlead_tools.learn.dataset import Episode
from fairlead_tools.parity.deployed_episode import by_tick, calls_with_rows, written_calls
from fairlead_tools.parity.local_episode import require_each_period
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from fairlead_tools.writable import room

if TYPE_CHECKING:
    from fairlead_skill_runner import TraceRecord

_TIMEOUT_S, _POLL_S = 10.0, 0.02


def record_deployed(
    source: Path,
    skill: SkillManifest,
    seeds: Iterable[int],
    most_ticks: int,
    folder: Path,
    on_tick: Callable[[int, int], None],
) -> Generator[Episode, None, None]:
    """Run the skill once in a new episode of each seed, on a private copy of ``source``.

    Args:
        most_ticks: the goal's deadline; what the answer that has begun by then still does counts.
        folder: emptied, then holds the services' state.
        on_tick: told of seed and tick.

    Raises:
        ConfigError: rows are not the simulator's own steps, or not its own vector.
        ServiceError: a service failed, or the policy was never asked.
    """
    deployment = load_deployment(source)
    require_each_period("dataset record", skill, load_robot(deployment.robot))
    hal, runner = deployment.only("hal_sim"), deployment.only("skill_runner")
    options: dict[str, dict[str, Any]] = {hal: {"trace": True}, runner: {"trace": True}}
    if not skill.images:
        options[hal]["cameras"] = []
    scratch = make_scratch(source, folder, ScratchOptions(pacing="lockstep", options=options))
    with scratch_robot(scratch) as robot:
        ear = _Ear(robot.client, skill, _periods(scratch.deployment, hal, skill))
        for seed in seeds:
            ear.forget()
            robot.client.reset_episode(seed)
            robot.client.arm()
            progress = run_goal(
                robot.client,
                GoalOptions(skill.id, deadline_ticks=most_ticks, runner=runner),
                partial(_tell, on_tick, seed),
            )
            robot.client.disarm()
            result = progress.result
            assert result is not None
            ticks = range(result.first_tick, result.last_tick)
            has_rows = calls_with_rows(progress) and ticks
            if result.outcome == "cancelled" or result.kind == "policy_error" or not has_rows:
                when = "" if has_rows else " before any row acted"
                raise ServiceError(
                    f"dataset record: seed {seed}: {result.outcome}{when}: {result.kind}: "
                    f"{result.detail}; logs: {folder / 'logs'}"
                )
            calls = written_calls(folder / runner, calls_with_rows(progress))
            episode = _Rows(skill, scratch.deployment.robot, calls, folder / hal).episode(
                seed, ear.observations(ticks), ticks
            )
            is_known = result.decided_by == "task" or skill.decided_by == "policy"
            yield replace(episode, succeeded=result.outcome == "succeeded" and is_known)


def _tell(on_tick: Callable[[int, int], None], seed: int, now: Progress) -> None:
    on_tick(seed, now.tick)


def _periods(deployment: Deployment, hal: str, skill: SkillManifest) -> dict[str, int]:
    """Ticks between the frames of each camera that the skill sees through."""
    from fairlead_hal_sim import HalSimOptions

    wanted = {spec.camera for spec in skill.images.values()}
    cameras = check_options(deployment, hal, HalSimOptions).cameras
    return {one.name: one.period_ticks for one in cameras if one.name in wanted}


def _wait(what: Callable[[], str]) -> None:
    """Until nothing is missing.

    Raises:
        ServiceError: with what still is.
    """
    until = time.monotonic() + _TIMEOUT_S
    while missing := what():
        if time.monotonic() > until:
            raise ServiceError(f"dataset record: {missing} never came")
        time.sleep(_POLL_S)


class _Ear:
    """What the services send to the runner."""

    def __init__(self, client: RobotClient, skill: SkillManifest, periods: dict[str, int]) -> None:
        self._skill, self._periods = skill, periods
        self._layouts: dict[int, LayoutState] = {}
        self._images: dict[tuple[str, int], Image] = {}
        client.bus.subscribe(client.keys.layout(skill.id), self._on_layout)
        for name in periods:
            client.bus.subscribe(client.keys.camera(name), self._on_image)

    def forget(self) -> None:
        """A new episode begins."""
        self._layouts.clear()
        self._images.clear()

    def observations(self, ticks: range) -> list[Observation]:
        """What the policy saw, or would have seen, in each of the ticks.

        Raises:
            ServiceError: something of a tick has not come.
        """
        from fairlead_skill_runner import ObservationBuffer

        _wait(lambda: self._missing(ticks))
        buffer = ObservationBuffer(
            self._skill, self._skill.prompt, self._periods, exact=True, has_task=False
        )
        images = sorted(self._images.items(), key=lambda item: item[0][1])
        seen = []
        for tick in ticks:
            while images and images[0][0][1] <= tick:
                buffer.add_image(images.pop(0)[1])
            buffer.add_layout(self._layouts[tick])
            seen.append(buffer.gather().observation)
        return seen

    def _missing(self, ticks: range) -> str:
        for tick in ticks:
            layout = self._layouts.get(tick)
            if layout is None or layout.values is None:
                return f"the state of tick {tick}"
            for name, period in self._periods.items():
                due = tick - (tick - layout.episode_tick) % period
                if (name, due) not in self._images:
                    return f"the picture of {name} of tick {due}"
        return ""

    def _on_layout(self, sample: Sample) -> None:
        layout = decode(LayoutState, sample.payload)
        self._layouts[layout.tick] = layout

    def _on_image(self, sample: Sample) -> None:
        image = decode(Image, sample.payload)
        self._images[image.camera, image.tick] = image


class _Rows:
    """What the policy said for each tick, and what the robot did in it."""

    def __init__(
        self, skill: SkillManifest, robot_id: str, calls: Sequence[TraceRecord], hal: Path
    ) -> None:
        self._skill, self._calls, self._hal = skill, calls, hal
        self._routes = resolve_routes(skill.action_contract, load_robot(robot_id))

    def episode(self, seed: int, seen: Sequence[Observation], ticks: range) -> Episode:
        """Of these ticks, not succeeded.

        Raises:
            ConfigError: a row that acted is not the vector that the simulator was given.
            ServiceError: the HAL's trace misses a tick.
        """
        from fairlead_skill_runner import pixels_of

        _wait(lambda: self._unwritten(ticks))
        steps, motion = by_tick(self._hal / "trace.jsonl"), by_tick(self._hal / "motion.jsonl")
        acted = np.array([np.frombuffer(bytes.fromhex(steps[t]["packed"]), "<f4") for t in ticks])
        released = np.array(
            [all(motion[t]["acted"][route.part][0] == 0 for route in self._routes) for t in ticks]
        )
        rows, sent = (
            np.array([self._row(tick, proposed) for tick in ticks]) for proposed in (False, True)
        )
        used = sorted(index for route in self._routes for index in route.sources)
        if acted.shape != sent.shape or (acted != sent)[released][:, used].any():
            raise ConfigError(
                f"dataset record: skill {self._skill.id}: expected rows that are the simulator's "
                f"own vector of {acted.shape[1]} numbers, in its order and scale, for every part; "
                "got others"
            )
        pictures = {
            name: pixels_of(spec, np.array([one.images[name] for one in seen]))
            for name, spec in self._skill.images.items()
        }
        states = np.array([one.state for one in seen])
        return Episode(seed, False, states, rows, acted, pictures, released=released)

    def _row(self, tick: int, proposed: bool) -> Actions:
        """Of the newest answer by then, NaN where it has none left; float32 ``[dim]``."""
        call = next(one for one in reversed(self._calls) if one.tick <= tick)
        rows = call.proposed if proposed else call.actions
        if tick - call.tick >= len(rows):
            return np.full(rows.shape[1], np.nan, np.float32)
        return np.array(rows[tick - call.tick])

    def _unwritten(self, ticks: range) -> str:
        for name in ("trace.jsonl", "motion.jsonl"):
            file = self._hal / name
            missing = set(ticks) - set(by_tick(file) if file.exists() else ())
            if missing:
                return f"the HAL's line of tick {min(missing)} in {file} ({room(file)})"
        return ""
