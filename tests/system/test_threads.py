"""Which thread runs what in services that run a goal."""

from __future__ import annotations

from contextlib import nullcontext, suppress
from pathlib import Path

import pytest

from bench.equipment.rendering import CAN_RENDER
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.registry import Registry
from fairlead.errors import RefusedError
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead_tools.supervisor.command_line import service_command
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.hal_mujoco.joint_reach import SKILL, SOURCE

pytestmark = [pytest.mark.processes, pytest.mark.timeout(180)]

RECORDED = Path(__file__).with_name("recorded_threads.py")
CAMERA = repo_root() / "compose" / "ur5e_robosuite_cameras.yaml"
SEEING = "bc-reach-cube"
OF_CAMERAS = {"frames", "cameras"}
"""Threads that only a robot with a camera has, in realtime."""
GOALS = 5
"""In realtime one that begins on a late machine may end before the runner has seen anything."""
ZENOH_POOLS = {"acc", "net", "rx", "tx"}
PASSING = {"close"}
"""Of the session, at the end."""


ENTRY_POINTS: dict[str, tuple[str, ...]] = {
    "main": (
        "GoalRun.run",
        "PolicyWorker.infer",
        "EpisodeResetHandler.handle",
        "AssemblerTransport.follow_wants",
    ),
    "receive": (
        "HalCore.on_lease",
        "HalCore.on_safe_chunk",
        "AssemblerCore.on_lease",
        "AssemblerCore.on_transforms",
        "AssemblerCore.on_joints",
        "RunCore.on_joints",
        "RunCore.on_layout",
        "RunCore.on_verdict",
    ),
    "frames": ("RunCore.on_image",),
    "cameras": ("TickPublisher.late_frame",),
    "tick": ("TickPublisher.finish", "HalCore.decide"),
    "log": (),
    "motion.jsonl": (),
    "trace.jsonl": (),
}
"""Methods that each thread calls, and no other thread: docs/design.md says what each is for."""


def pools_of(robot: ScratchRobot) -> set[str]:
    """Names of the pools of threads that Zenoh has in the services."""
    names = {
        task.read_text()
        for service in robot.scratch.deployment.services
        for task in Path(f"/proc/{robot.supervisor.pid(service)}/task").glob("*/comm")
    }
    return {name.split("-")[0] for name in names} & ZENOH_POOLS


@pytest.mark.parametrize(
    "sees",
    [
        False,
        pytest.param(
            True,
            marks=[
                pytest.mark.simulator,
                pytest.mark.skipif(not CAN_RENDER, reason="no rendering library on this machine"),
            ],
        ),
    ],
)
def test_each_entry_point_is_called_by_its_thread(tmp_path: Path, sees: bool) -> None:
    seen = tmp_path / "threads"

    def recorded(file: Path, deployment: Deployment, service: str, state_dir: Path) -> list[str]:
        python, *words = service_command(file, deployment, service, state_dir)
        if words[0] != "-m":  # the gate
            return [python, *words]
        return [python, str(RECORDED), str(seen), *words[1:]]

    skill = SEEING if sees else SKILL
    options: dict[str, dict[str, object]] = {"runner": {"skills": [skill], "trace": True}}
    if sees:
        options["hal"] = {"trace": True}
    scratch = make_scratch(
        CAMERA if sees else SOURCE,
        tmp_path / "robot",
        ScratchOptions(pacing="realtime" if sees else "lockstep", options=options),
    )
    with scratch_robot(scratch, Registry(tmp_path / "state"), command=recorded) as robot:
        assert pools_of(robot) == {"acc"}, "Zenoh reads, decides and writes in one pool"
        result = None
        for _ in range(GOALS):
            for stop in robot.client.gate_status().stop_ids:
                robot.client.reset(stop)
            robot.client.disarm()
            robot.client.reset_episode(0)
            with nullcontext() if not sees else suppress(RefusedError):
                robot.client.arm()
                result = run_goal(robot.client, GoalOptions(skill, deadline_ticks=100)).result
            if "RunCore.on_image" in seen.read_text(encoding="utf-8") or not sees:
                break
        assert result is not None
        assert sees or result.outcome == "succeeded"
    called = {tuple(line.split(" ", 1)) for line in seen.read_text(encoding="utf-8").splitlines()}
    threads = set(ENTRY_POINTS) - (set() if sees else OF_CAMERAS)
    wanted = {(entry, thread) for thread in threads for entry in ENTRY_POINTS[thread]}
    entries = {entry for entry, _ in wanted}
    assert {pair for pair in called if pair[0] in entries} == wanted
    started = {thread for what, thread in called if what == "started"}
    assert started - PASSING == threads - {"main", "receive"}
