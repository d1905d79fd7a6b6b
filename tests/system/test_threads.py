"""Which thread runs what: as docs/design.md says, in services that run a goal."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.registry import Registry
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead_tools.supervisor.command_line import service_command
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.hal_mujoco.joint_reach import RUNNER, SKILL, SOURCE

pytestmark = [pytest.mark.processes, pytest.mark.timeout(180)]

RECORDED = Path(__file__).with_name("recorded_threads.py")


def documented() -> set[tuple[str, str]]:
    """Entry points and their threads, from the document's table."""
    text = (repo_root() / "docs" / "design.md").read_text(encoding="utf-8")
    section = text.partition("## Which thread runs what")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` \|(.*)\|.*\|$", section, re.M)
    return {(entry, thread) for thread, cell in rows for entry in re.findall(r"`(\w+\.\w+)`", cell)}


def test_each_entry_point_is_called_by_the_thread_that_the_document_names(tmp_path: Path) -> None:
    seen = tmp_path / "threads"

    def recorded(file: Path, deployment: Deployment, service: str, state_dir: Path) -> list[str]:
        python, *words = service_command(file, deployment, service, state_dir)
        if words[0] != "-m":  # the gate
            return [python, *words]
        return [python, str(RECORDED), str(seen), *words[1:]]

    options = ScratchOptions(pacing="lockstep", options={"runner": RUNNER})
    scratch = make_scratch(SOURCE, tmp_path / "robot", options)
    with scratch_robot(scratch, Registry(tmp_path / "state"), command=recorded) as robot:
        robot.client.reset_episode(0)
        robot.client.arm()
        result = run_goal(robot.client, GoalOptions(SKILL)).result
        assert result is not None and result.outcome == "succeeded"
    called = {tuple(line.split()) for line in seen.read_text(encoding="utf-8").splitlines()}
    wanted = documented()
    entries = {entry for entry, _ in wanted}
    assert len(entries) > 10
    assert {pair for pair in called if pair[0] in entries} == wanted
