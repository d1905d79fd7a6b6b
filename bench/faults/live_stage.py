"""A whole robot without physics, in realtime, that keeps executing rows until something happens."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import yaml

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import LiveRobot, wait_for
from bench.equipment.motion_log import MotionLine, hold_delay_ms, longest_tick_ms
from bench.faults.motion_rules import every_row_was_judged_for_its_tick
from bench.faults.other_load import OtherLoad
from bench.faults.row import MachineLateError, Shot
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.registry import Registry
from fairlead.errors import FairleadError
from fairlead.messages import GateState, GoalResult, Hold, Lease, decode
from fairlead.operate.goal_hearing import Progress
from fairlead.paths import repo_root, rskill_dir
from fairlead.wire.bus import Sample
from fairlead_tools.supervisor.command_line import service_command
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)

SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"
SKILL = "steady-motion"
TURN_RAD_S = 0.6
BEFORE_TICKS = 10
TICK_S = 0.05
ATTEMPTS = 3
LATE_TICK_MS = 75.0  # no lease lives longer
OTHERS_CORES = 0.25
"""Others on the machine that keep more busy may be why a robot in realtime holds."""


@dataclass(frozen=True)
class Changes:
    """How a robot differs from the shipped deployment.

    environment: by service ("" for all of them), variables it is started with.
    command: makes a service's words from the usual ones.
    """

    pacing: str = "realtime"
    environment: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    command: Callable[[str, list[str]], list[str]] = lambda service, words: words
    access: Literal["closed", "open"] = "closed"

    def words(self, file: Path, deployment: Deployment, service: str, state: Path) -> list[str]:
        """The command line of one service."""
        usual = service_command(file, deployment, service, state)
        mine = {**self.environment.get("", {}), **self.environment.get(service, {})}
        variables = [f"{name}={value}" for name, value in mine.items()]
        return ["env", *variables, *self.command(service, usual)]


class LiveStage(LiveRobot):
    """A robot whose base turns for as long as its goal lasts, and the gate's leases.

    leases: CLOCK_MONOTONIC of the arrival [ns], and the lease.
    """

    def __init__(self, robot: ScratchRobot, skill: str = SKILL) -> None:
        super().__init__(robot, skill)
        self.leases: list[tuple[int, Lease]] = []
        self._chance = random.Random()
        self._others = OtherLoad()
        self.client.bus.subscribe(self.client.keys.lease, self._on_lease)

    def _on_lease(self, sample: Sample) -> None:
        self.leases.append((time.monotonic_ns(), decode(Lease, sample.payload)))
        if len(self.leases) > 4000:
            del self.leases[:2000]

    def start_moving(self, seed: int = 0) -> Future[Progress]:
        """As every live robot; a machine too busy to begin a goal in realtime is asked again.

        Returns at any moment of a tick: the motion log is read just after one was decided, and
        faults that always came then would not meet the worst case.
        """
        others, failures = OtherLoad(), list[Exception]()
        while True:
            try:
                goal = super().start_moving(seed)
                break
            except (AssertionError, FairleadError) as error:
                print(f"not moving yet: {error}")
                failures.append(error)
            if len(failures) == ATTEMPTS and others.cores() > OTHERS_CORES:
                raise MachineLateError(f"no goal began to move: {failures[-1]}")
            if len(failures) == ATTEMPTS:
                raise failures[-1]
        threading.Event().wait(self._chance.uniform(0.0, TICK_S))
        self._others = OtherLoad()
        return goal

    # --- measurements ----------------------------------------------------------------

    def hold_shot(self, injected_ns: int, note: str = "") -> Shot:
        """Injection to the first tick from which on nothing moved; then the rules of all rows."""
        delay_ms = hold_delay_ms(self.motion_ended(injected_ns), injected_ns)
        every_row_was_judged_for_its_tick(self)
        ended_ns = injected_ns + int(delay_ms * 1e6)
        return Shot(delay_ms, injected_ns, ended_ns, self.tick_ms(injected_ns), note)

    def tick_ms(self, before_ns: int) -> float:
        """The longest of the last undisturbed ticks."""
        lines = [line for line in self.motion.read()[-400:] if line.stamp_ns < before_ns]
        return longest_tick_ms(lines[-BEFORE_TICKS:])

    def none_held(self, lines: Sequence[MotionLine]) -> None:
        """Asserts that rows acted in each of some ticks of the goal; raises as `no_hold_between`.

        What the robot's own processes show is no excuse: a fault that makes them late is the
        product's. What others on the machine took from them is.
        """
        held = [line.tick for line in lines if not line.moves]
        tick_ms = longest_tick_ms(list(lines))
        gap_ms = self.lease_gap_ms(lines[0].stamp_ns, lines[-1].stamp_ns)
        old_ms = max((line.stamp_ns - line.lease_ns) / 1e6 for line in lines)
        others = self._others.cores()
        text = (
            f"held in ticks {held} of {len(lines)} ({', '.join(hold_names(lines))}); "
            f"longest tick {tick_ms:.0f} ms, gap of leases "
            f"{gap_ms:.0f} ms here, oldest lease {old_ms:.0f} ms there; others on the machine "
            f"kept {others:.2f} cores busy"
        )
        if held and others > OTHERS_CORES:
            raise MachineLateError(text)
        assert not held, text

    @property
    def others_are_busy(self) -> bool:
        """Whether others on the machine took much of it since the robot began to move."""
        return self._others.cores() > OTHERS_CORES

    def lease_gap_ms(self, began_ns: int, ended_ns: int) -> float:
        """The longest time between two leases of a stretch, as this process heard them."""
        stamps = [stamp for stamp, _ in list(self.leases) if began_ns <= stamp <= ended_ns]
        return max((later - one for one, later in pairwise(stamps)), default=0) / 1e6

    def stop_ms(self, injected_ns: int) -> float:
        """Injection to the gate's first lease that says stopped or latched."""
        found: list[int] = []

        def stopped() -> bool:
            found[:] = [
                stamp
                for stamp, lease in list(self.leases)
                if stamp >= injected_ns and lease.state in (GateState.STOPPED, GateState.LATCHED)
            ]
            return bool(found)

        wait_for(stopped, "a lease says stopped")
        return (found[0] - injected_ns) / 1e6

    def no_hold_between(self, began_ns: int, ended_ns: int) -> int:
        """Asserts that rows acted in every tick of a stretch; how many.

        Raises:
            MachineLateError: they did not, but others kept the machine busy.
        """
        wait_for(lambda: self.motion.read()[-1].stamp_ns > ended_ns, "the stretch is over")
        lines = [line for line in self.motion.lines if began_ns <= line.stamp_ns <= ended_ns]
        assert lines, "no tick in that stretch"
        self.none_held(lines)
        return len(lines)

    # --- the way back ----------------------------------------------------------------

    def ended(self, goal: Future[Progress]) -> GoalResult:
        """How a goal ended."""
        result = goal.result(timeout=60.0).result
        assert result is not None
        return result

    def finish(self, goal: Future[Progress]) -> None:
        """End a goal that still runs; whatever it said."""
        if self.client.gate_status().state == GateState.ARMED:
            self.client.disarm()
        try:
            goal.result(timeout=60.0)
        except FairleadError:  # the runner may have died meanwhile
            return


def hold_names(lines: Sequence[MotionLine]) -> list[str]:
    """Why parts held, each reason once."""
    holds = {hold for line in lines for hold in line.holds}
    return [Hold(hold).name for hold in sorted(holds - {Hold.NONE})]


def steady_skill(folder: Path) -> Path:
    """A folder of skills with one whose policy always says: turn, arm still, gripper closed."""
    oracle = yaml.safe_load((rskill_dir("oracle-counter-to-cabinet") / "rskill.yaml").read_text())
    manifest: dict[str, Any] = {
        **{name: oracle[name] for name in ("licence", "embodiments", "prompt", "state_contract")},
        "id": SKILL, "version": "0.1.0", "model_family": "test",
        "policy": {"backend": "constant", "options": {"row": [*[0.0] * 8, TURN_RAD_S / 1.5, 1.0]}},
        "action_contract": {
            "dim": 10,
            "slots": [
                {"range": [0, 5], "control_mode": "cartesian_delta", "ee": "gripper",
                 "frame": "base_link", "scale": [0.05] * 3 + [0.5] * 3},
                {"range": [6, 8], "control_mode": "joint_velocity",
                 "joint_names": ["base_x", "base_y", "base_yaw"], "scale": [1.0, 1.0, 1.5]},
                {"range": [9, 9], "control_mode": "gripper_position", "ee": "gripper",
                 "scale": -0.04, "offset": 0.04},
            ],
        },
        "rate_hz": 20.0, "horizon": 16, "execute_steps": 8, "age_max_ticks": 8,
        "inference_timeout_s": 5.0,
    }  # fmt: skip
    (folder / SKILL).mkdir(parents=True)
    text = yaml.safe_dump(manifest)
    (folder / SKILL / "rskill.yaml").write_text(text, encoding="utf-8")
    return folder


def with_skill(folder: Path, changes: Changes) -> Changes:
    """The same changes for services that also know the steady skill."""
    everywhere = dict(changes.environment.get("", {}))
    everywhere["FAIRLEAD_SKILLS"] = str(steady_skill(folder / "skills"))
    return replace(changes, environment={**changes.environment, "": everywhere})


@contextmanager
def live_stage(
    folder: Path, changes: Changes | None = None, simulator: Mapping[str, Any] | None = None
) -> Iterator[LiveStage]:
    """All services, started.

    Args:
        simulator: options of `hal_sim`; None: as a rule, a HAL without physics.
    """
    changes = with_skill(folder, changes or Changes())
    assert changes.pacing in ("realtime", "lockstep")
    pacing: Any = changes.pacing
    options = ScratchOptions(
        pacing=pacing,
        access=changes.access,
        ports=changes.access == "open",
        hal=LIGHT_HAL if simulator is None else None,
        options={"hal": dict(simulator or {})},
    )
    scratch = make_scratch(SOURCE, folder / "state", options)
    registry = Registry(folder / "registry")
    with scratch_robot(scratch, registry, command=changes.words) as robot:
        yield LiveStage(robot)
