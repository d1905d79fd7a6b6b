"""A service's real-time priority: of all its threads, not of what computes for it; or refused."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.scheduling import realtime_words
from fairlead.errors import ConfigError
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot

SOURCE = repo_root() / "compose" / "panda_mujoco.yaml"
SKILL = "panda-joint-reach"
PRIORITY = 7
NOT_PERMITTED = ["setpriv", "--bounding-set=-sys_nice", "prlimit", "--rtprio=0"]


def with_priority(folder: Path, *services: str, **more: object) -> Path:
    deployment = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
    for service in services:
        deployment["services"][service] |= {"realtime_priority": PRIORITY} | more
    file = folder / "realtime.yaml"
    file.write_text(yaml.safe_dump(deployment), encoding="utf-8")
    return file


def priorities(pid: int) -> set[tuple[int, int]]:
    threads = [int(task.name) for task in Path(f"/proc/{pid}/task").iterdir()]
    return {(os.sched_getscheduler(one), os.sched_getparam(one).sched_priority) for one in threads}


def children(pid: int) -> Iterator[int]:
    for task in Path(f"/proc/{pid}/task").iterdir():
        yield from (int(child) for child in (task / "children").read_text().split())


def is_policy(pid: int) -> bool:
    return b"policy_process" in Path(f"/proc/{pid}/cmdline").read_bytes()


@pytest.mark.processes
def test_every_thread_of_a_service_has_its_priority_and_the_policy_an_ordinary_one(
    tmp_path: Path,
) -> None:
    try:
        realtime_words("hal", PRIORITY)
    except ConfigError as error:
        pytest.skip(f"needs the permission that it is about: {error}")
    file = with_priority(tmp_path, "hal", "safety", "runner")
    scratch = make_scratch(file, tmp_path / "robot", ScratchOptions())
    with scratch_robot(scratch) as robot:
        robot.client.arm()
        progress = run_goal(robot.client, GoalOptions(SKILL))
        assert progress.result is not None and progress.result.outcome == "succeeded", progress
        pids = {name: robot.supervisor.pid(name) for name in scratch.deployment.services}
        for name in ("hal", "safety", "runner"):
            assert priorities(pids[name]) == {(os.SCHED_FIFO, PRIORITY)}, name
        (policy,) = filter(is_policy, children(pids["runner"]))
        ordinary = {(os.SCHED_OTHER, 0)}
        assert priorities(policy) == priorities(pids["state_assembler"]) == ordinary


@pytest.mark.processes
def test_a_priority_that_the_system_does_not_permit_is_refused_before_anything_starts(
    tmp_path: Path,
) -> None:
    file = with_priority(tmp_path, "safety")
    up = [*NOT_PERMITTED, sys.executable, "-m", "fairlead_tools.cli.main", "up", str(file)]
    done = subprocess.run(up, capture_output=True, text=True, timeout=60.0, check=False)
    assert done.returncode == 1, done
    said = "service safety: realtime_priority: expected the permission for 7"
    assert said in " ".join(done.stderr.split()) and "Traceback" not in done.stderr
    assert "hal" not in done.stdout, "nothing was started"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"realtime_priority": 100}, "less than or equal to 99"),
        ({"run": "external"}, "for who starts it to give"),
    ],
)
def test_a_priority_that_nobody_could_give_is_refused(
    tmp_path: Path, more: dict[str, object], said: str
) -> None:
    with pytest.raises(ConfigError, match=said):
        load_deployment(with_priority(tmp_path, "hal", **more))
