"""``fairlead run`` and ``eval`` have a policy loaded before they arm the robot."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.live_robot import wait_for
from fairlead.messages import GateState
from fairlead_tools.supervisor.scratch import ScratchRobot
from tests.cli.command import fairlead, fairlead_command, fairlead_environment
from tests.cli.kinematic_panda import SKILL, kinematic_panda
from tests.runner.policy_servers import OpenpiServer

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]


@pytest.fixture
def server() -> Iterator[OpenpiServer]:
    """It answers no request before it may go on, and then none at all."""

    def late(request: object, number: int) -> None:
        made.go_on.wait()

    made = OpenpiServer(late)
    yield made
    made.close()


@pytest.fixture
def robot(tmp_path: Path, server: OpenpiServer) -> Iterator[ScratchRobot]:
    policy = {"backend": "openpi", "options": {
        "address": server.address, "start": "serve", "connect_timeout_s": 4,
        "answer_timeout_s": 4}}  # fmt: skip
    with kinematic_panda(tmp_path, policy) as made:
        yield made


def wait_until_it_loads(run: subprocess.Popen[str], server: OpenpiServer) -> None:
    def loads() -> bool:
        assert run.poll() is None, run.communicate()
        return bool(server.requests)

    wait_for(loads, "the policy is being loaded")


@pytest.mark.parametrize("command", [("run",), ("eval", "--seeds", "0")])
def test_a_robot_is_not_armed_while_the_policy_loads_nor_if_it_cannot_be_loaded(
    robot: ScratchRobot, server: OpenpiServer, tmp_path: Path, command: tuple[str, ...]
) -> None:
    before = robot.client.gate_status()
    name, *words = command
    run = subprocess.Popen(
        fairlead_command(name, SKILL, "-d", str(robot.scratch.file), *words),
        env=fairlead_environment(tmp_path / "registry"),
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until_it_loads(run, server)
    assert run.stderr is not None
    said = iter(run.stderr.readline, "")
    assert any(f"{SKILL}: its policy is being loaded" in line for line in said)
    assert robot.client.gate_status().state == GateState.DISARMED
    server.go_on.set()
    _, errors = run.communicate(timeout=30.0)
    assert run.returncode == 1, errors
    assert errors.count(f"skill {SKILL} is not loaded: policy worker: loading failed") == 1
    assert "fairlead logs runner" in errors
    gate = robot.client.gate_status()
    assert (gate.state, gate.epoch) == (GateState.DISARMED, before.epoch), "it was never armed"


def test_an_interrupted_run_whose_policy_loads_leaves_the_robot_disarmed(
    robot: ScratchRobot, server: OpenpiServer, tmp_path: Path
) -> None:
    run = subprocess.Popen(
        fairlead_command("run", SKILL, "-d", str(robot.scratch.file)),
        env=fairlead_environment(tmp_path / "registry"),
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until_it_loads(run, server)
    run.send_signal(signal.SIGINT)
    _, errors = run.communicate(timeout=30.0)
    assert run.returncode == 130, errors
    assert robot.client.gate_status().state == GateState.DISARMED


def test_eval_refuses_a_stopped_gate_before_it_says_anything_else(
    robot: ScratchRobot, tmp_path: Path
) -> None:
    stop_id = robot.client.stop("test")
    words = ("eval", SKILL, "-d", str(robot.scratch.file), "--seeds", "0:2")
    done = fairlead(*words, state=tmp_path / "registry")
    robot.client.reset(stop_id)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("ERROR fairlead eval"), done.stderr
    assert "the gate is stopped" in done.stderr
