"""A panda without physics in realtime, whose skill is driven by another policy."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bench.equipment.live_robot import recover, wait_for
from fairlead.deploy.registry import Registry
from fairlead.messages import GateState
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)

SKILL = "panda-joint-reach"


@contextmanager
def kinematic_panda(folder: Path, policy: dict[str, Any]) -> Iterator[ScratchRobot]:
    """Runs while the block lasts. policy: instead of `SKILL`'s own."""
    scratch = make_scratch(
        repo_root() / "compose" / "panda_mujoco.yaml",
        folder / "state",
        ScratchOptions(
            pacing="realtime",
            hal={"run": "hal_kinematic"},
            options={"runner": {"policies": {SKILL: policy}}},
        ),
    )
    with scratch_robot(scratch, Registry(folder / "registry")) as made:
        yield made


def make_idle(robot: ScratchRobot) -> None:
    """What a test left behind is over: no goal runs, no stop holds, the robot is disarmed."""
    client = robot.client
    wait_for(lambda: not any(one.is_running for one in client.status().runners), "no goal runs")
    recover(client)
    if client.gate_status().state == GateState.ARMED:
        client.disarm()
