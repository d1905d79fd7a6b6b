"""``fairlead run`` and ``eval`` have a policy loaded before they arm the robot."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator

import pytest

from bench.equipment.live_robot import wait_for
from fairlead.messages import GateState
from fairlead_tools.supervisor.scratch import ScratchRobot
from tests.cli.command import fairlead_command, fairlead_environment, fairlead_here
from tests.cli.kinematic_panda import SKILL, kinematic_panda, make_idle
from tests.runner.policy_servers import OpenpiServer

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]


@pytest.fixture(scope="module")
def silent() -> Iterator[OpenpiServer]:
    """It answers no request before it may go on, and then none at all."""

    def late(request: object, number: int) -> None:
        made.go_on.wait()

    made = OpenpiServer(late)
    yield made
    made.close()


@pytest.fixture(scope="module")
def shared(
    silent: OpenpiServer, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[ScratchRobot]:
    policy = {"backend": "openpi", "options": {
        "address": silent.address, "start": "serve", "connect_timeout_s": 4,
        "answer_timeout_s": 4}}  # fmt: skip
    with kinematic_panda(tmp_path_factory.mktemp("loading"), policy) as made:
        yield made


@pytest.fixture
def robot(shared: ScratchRobot) -> ScratchRobot:
    make_idle(shared)
    return shared


@pytest.fixture
def server(silent: OpenpiServer, robot: ScratchRobot) -> Iterator[OpenpiServer]:
    """Nobody has asked it yet."""
    silent.requests.clear()
    silent.go_on.clear()
    yield silent
    silent.go_on.set()


def environment(robot: ScratchRobot) -> dict[str, str]:
    return fairlead_environment(robot.scratch.state_dir.parent / "registry")


def wait_until_it_loads(run: subprocess.Popen[str], server: OpenpiServer) -> None:
    def loads() -> bool:
        assert run.poll() is None, run.communicate()
        return bool(server.requests)

    wait_for(loads, "the policy is being loaded")


@pytest.mark.parametrize("command", [("run",), ("eval", "--seeds", "0")])
def test_a_robot_is_not_armed_while_the_policy_loads_nor_if_it_cannot_be_loaded(
    robot: ScratchRobot, server: OpenpiServer, command: tuple[str, ...]
) -> None:
    before = robot.client.gate_status()
    name, *words = command
    run = subprocess.Popen(
        fairlead_command(name, SKILL, "-d", str(robot.scratch.file), *words),
        env=environment(robot),
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
    robot: ScratchRobot, server: OpenpiServer
) -> None:
    run = subprocess.Popen(
        fairlead_command("run", SKILL, "-d", str(robot.scratch.file)),
        env=environment(robot),
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until_it_loads(run, server)
    run.send_signal(signal.SIGINT)
    _, errors = run.communicate(timeout=30.0)
    assert run.returncode == 130, errors
    assert robot.client.gate_status().state == GateState.DISARMED


def test_eval_refuses_a_stopped_gate_before_it_says_anything_else(
    robot: ScratchRobot,
) -> None:
    stop_id = robot.client.stop("test")
    words = ("eval", SKILL, "-d", str(robot.scratch.file), "--seeds", "0:2")
    done = fairlead_here(*words, state=robot.scratch.state_dir.parent / "registry")
    robot.client.reset(stop_id)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("ERROR fairlead eval"), done.stderr
    assert "the gate is stopped" in done.stderr
