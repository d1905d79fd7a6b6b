"""The complete HAL that the document names: short, and it runs behind the real gate."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
import yaml

from fairlead.messages import JointState, decode, floats
from fairlead.operate.client import RobotClient
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root
from fairlead_tools.supervisor.command_line import service_command, service_environment
from fairlead_tools.supervisor.scratch import Scratch, ScratchOptions, make_scratch
from tests.cli.command import fairlead_here as fairlead
from tests.hal_mujoco.joint_reach import RUNNER, SKILL, SOURCE, goal_position

EXAMPLE = repo_root() / "docs" / "examples" / "minimal_hal.py"
DOCUMENT = repo_root() / "docs" / "hal.md"
END_S = 20.0


def test_the_example_is_under_80_lines() -> None:
    assert len(EXAMPLE.read_text(encoding="utf-8").splitlines()) < 80


def test_the_lines_that_swap_the_hal_are_those_of_the_deployment_file() -> None:
    lines = re.findall(r"^  hal: \{.*$", DOCUMENT.read_text(encoding="utf-8"), re.M)
    assert len(lines) == 2
    assert all(line.strip() in SOURCE.read_text(encoding="utf-8") for line in lines)


@contextmanager
def running(scratch: Scratch) -> Iterator[None]:
    """The deployment's services, with the example as its HAL."""
    with ExitStack() as ends:
        for name in scratch.deployment.services:
            folder = scratch.state_dir / name
            folder.mkdir()
            command = service_command(scratch.file, scratch.deployment, name, folder)
            log = ends.enter_context((folder / "log").open("wb"))
            process = subprocess.Popen(
                command, stdout=log, stderr=subprocess.STDOUT, env=service_environment()
            )
            ends.callback(process.wait, END_S)
            ends.callback(process.terminate)
        yield


def with_script(script: Path, folder: Path) -> Scratch:
    """The deployment, with a script as its HAL."""
    source = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
    source["services"]["hal"] = {"command": ["python", str(script)]}
    file = folder / "with_a_script.yaml"
    file.write_text(yaml.safe_dump(source, sort_keys=False), encoding="utf-8")
    return make_scratch(file, folder / "state", ScratchOptions(options={"runner": RUNNER}))


@pytest.mark.processes
def test_the_example_reaches_the_goal_behind_the_real_gate(tmp_path: Path) -> None:
    scratch = with_script(EXAMPLE, tmp_path)
    with running(scratch), RobotClient(scratch.deployment) as client:
        client.wait_alive(*scratch.deployment.services, timeout_s=60.0)
        client.wait_gate_follows(30.0)
        states: list[JointState] = []
        client.bus.subscribe(
            client.keys.joints, lambda sample: states.append(decode(JointState, sample.payload))
        )
        client.arm()
        result = run_goal(client, GoalOptions(SKILL, deadline_ticks=80)).result
        client.disarm()
    assert result is not None and result.outcome == "deadline", "it has no task that could succeed"
    np.testing.assert_allclose(floats(states[-1].positions)[:8], goal_position(), atol=1e-6)


@pytest.mark.processes
def test_a_hal_that_measures_in_degrees_is_warned_of_by_status(tmp_path: Path) -> None:
    script = tmp_path / "degrees.py"
    text = EXAMPLE.read_text(encoding="utf-8")
    radians = "Measurement(self.positions.copy(),"
    assert radians in text
    script.write_text(text.replace(radians, "Measurement(np.degrees(self.positions),"))
    scratch = with_script(script, tmp_path)
    with running(scratch), RobotClient(scratch.deployment) as client:
        client.wait_alive(*scratch.deployment.services, timeout_s=60.0)
        client.wait_gate_follows(30.0)
        said = fairlead("status", "-d", str(scratch.file), "--json", state=scratch.state_dir)
    warnings = json.loads(said.stdout)["warnings"]
    elbow = "measured outside its limits: panda_joint4: -126 rad, declared -3.0718 to -0.0698; "
    assert any(one.startswith(elbow) for one in warnings), warnings
