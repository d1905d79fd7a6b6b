"""A signal ends ``fairlead run``: the goal is known to have ended, or the robot is stopped."""

from __future__ import annotations

import re
import signal
import subprocess
from collections.abc import Iterator

import pytest

from bench.equipment.live_robot import wait_for
from fairlead.errors import RefusedError
from fairlead.messages import GateState
from fairlead.operate.client import RobotClient
from fairlead_tools.cli.arming import armed
from fairlead_tools.supervisor.scratch import ScratchRobot
from tests.cli.command import fairlead_command, fairlead_environment
from tests.cli.kinematic_panda import SKILL, kinematic_panda, make_idle

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]

SLOW = {"backend": "joint_reach", "options": {
    "target_rad": [0.4, 0.1, 0.2, -1.9, 0.1, 2.1, 0.9], "opening_m": 0.04, "step_rad": 0.0001,
}}  # fmt: skip
"""It moves for as long as a test may take."""


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ScratchRobot]:
    with kinematic_panda(tmp_path_factory.mktemp("interrupted"), SLOW) as made:
        yield made


@pytest.fixture
def robot(shared: ScratchRobot) -> ScratchRobot:
    make_idle(shared)
    return shared


def run_until_it_moves(robot: ScratchRobot, *before: str) -> subprocess.Popen[str]:
    released = counted(robot)
    run = subprocess.Popen(
        [*before, *fairlead_command("run", SKILL, "--deployment", str(robot.scratch.file))],
        env=environment(robot),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )

    def moves() -> bool:
        assert run.poll() is None, run.communicate()
        return counted(robot) > released

    wait_for(moves, "rows act")
    return run


def counted(robot: ScratchRobot) -> int:
    return dict(robot.client.gate_status().counters)["released"]


def environment(robot: ScratchRobot) -> dict[str, str]:
    return fairlead_environment(robot.scratch.state_dir.parent / "registry")


@pytest.mark.parametrize(
    "ending",
    [
        signal.SIGINT,
        *(pytest.param(one, marks=pytest.mark.thorough) for one in (signal.SIGTERM, signal.SIGHUP)),
    ],
)
def test_an_interrupted_run_says_how_the_goal_ended_and_disarms(
    robot: ScratchRobot, ending: signal.Signals
) -> None:
    run = run_until_it_moves(robot)
    run.send_signal(ending)
    said, errors = run.communicate(timeout=30.0)
    assert (run.returncode, "cancelled" in said) == (130, True), said + errors
    assert robot.client.gate_status().state == GateState.DISARMED


def test_a_run_in_the_background_of_a_script_is_ended_by_kill(
    robot: ScratchRobot,
) -> None:
    """A shell without a terminal has such a process ignore Ctrl-C."""
    deaf = ("sh", "-c", "trap '' INT; exec \"$@\"", "sh")
    run = run_until_it_moves(robot, *deaf)
    try:
        run.terminate()
        said, errors = run.communicate(timeout=30.0)
    finally:
        run.kill()
    assert (run.returncode, "cancelled" in said) == (130, True), said + errors
    assert robot.client.gate_status().state == GateState.DISARMED


def test_where_the_runner_does_not_confirm_the_robot_is_stopped_and_the_run_says_so(
    robot: ScratchRobot,
) -> None:
    run = run_until_it_moves(robot)
    pid = robot.supervisor.pid("runner")
    subprocess.run(["kill", "-STOP", str(pid)], check=True)
    try:
        run.send_signal(signal.SIGINT)
        _, errors = run.communicate(timeout=30.0)
        gate = robot.client.gate_status()
        assert (run.returncode, gate.state) == (130, GateState.STOPPED), errors
        said = re.search(
            r"runner did not confirm that the goal ended: a protective stop holds the robot\n"
            r"  try: fairlead reset ([0-9a-f]{16})\n",
            errors,
        )
        assert said is not None, errors
        assert gate.stop_ids == (int(said.group(1), 16),)
    finally:
        subprocess.run(["kill", "-CONT", str(pid)], check=True)


def test_of_two_runs_the_one_that_armed_and_is_refused_leaves_the_disarming_to_the_other(
    robot: ScratchRobot,
) -> None:
    with RobotClient(robot.scratch.deployment, by="fairlead run") as refused:
        with pytest.raises(RefusedError, match="is still running"), armed(refused):
            other = run_until_it_moves(robot)  # it finds the gate armed
            refused.run(SKILL)
        assert robot.client.gate_status().state == GateState.ARMED
    other.send_signal(signal.SIGINT)
    said, errors = other.communicate(timeout=30.0)
    assert (other.returncode, "cancelled" in said) == (130, True), said + errors
    assert robot.client.gate_status().state == GateState.DISARMED


def test_a_run_without_any_output_ends_as_others_do_and_disarms(
    robot: ScratchRobot,
) -> None:
    file = str(robot.scratch.file)
    command = fairlead_command("run", SKILL, "-d", file, "--deadline-ticks", "20")
    subprocess.run(
        ["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", *command],
        env=environment(robot),
        timeout=60.0,
        check=False,
    )
    [runner] = robot.client.status().runners
    assert runner.result is not None and runner.result.outcome == "deadline", runner
    assert robot.client.gate_status().state == GateState.DISARMED
