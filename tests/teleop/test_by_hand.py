"""A person at a keyboard drives a simulated arm: real terminal, services, gate and physics."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.live_robot import recover, wait_for
from bench.equipment.terminal import Terminal
from fairlead.messages import FloatArray, GateState, floats
from fairlead.robot.manifest import load_robot
from fairlead_tools.supervisor.scratch import ScratchRobot
from tests.cli.command import fairlead_here as fairlead
from tests.cli.command import terminal
from tests.teleop.slow_robot import slow_robot

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]

ROBOT = load_robot("ur5e")
ARM = list(range(6))
STEP = np.array(ROBOT.profile("sim").parts["arm"].joint_position.step_limits)  # type: ignore[union-attr]
STILL_TICKS = 20


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ScratchRobot]:
    """A UR5e in MuJoCo at the robot's own pace, and a skill that takes its time."""
    folder = tmp_path_factory.mktemp("teleop")
    with slow_robot(folder, "ur5e_mujoco", "ur5e-reach", 0.004) as robot:
        yield robot


Start = Callable[..., Terminal]


@pytest.fixture
def teleop(running: ScratchRobot, tmp_path: Path) -> Iterator[Start]:
    """Starts ``fairlead teleop`` where the episode begins."""
    recover(running.client)
    running.client.disarm()
    running.client.reset_episode(0)
    started: list[Terminal] = []

    def start(*arguments: str) -> Terminal:
        words = ("teleop", "-d", str(running.scratch.file), *arguments)
        started.append(terminal(tmp_path, *words))
        return started[-1]

    yield start
    for person in started:
        person.end()


def joints(running: ScratchRobot) -> FloatArray:
    with running.client.joint_states(queue=1) as states:
        state = states.next(5.0)
    assert state is not None
    return floats(state.positions)[ARM]


def claims(running: ScratchRobot) -> list[tuple[str, tuple[str, ...]]]:
    return [(one.source, one.parts) for one in running.client.gate_status().claims]


def refused(running: ScratchRobot) -> int:
    """Chunks that the gate has refused or truncated so far."""
    counters = dict(running.client.gate_status().counters)
    return counters["refused"] + counters["truncated"]


def comes_to_rest(running: ScratchRobot) -> int:
    """Ticks from now until the joints stand still."""
    before = None
    for ticks, state in enumerate(running.client.joint_states()):
        now = floats(state.positions)[ARM]
        if before is not None and np.abs(now - before).max() < 1e-4:
            return ticks
        before = now
    raise AssertionError


def test_joints_move_with_the_clutch_only_stop_with_the_key_and_ctrl_c_gives_back(
    running: ScratchRobot, teleop: Start
) -> None:
    start, refused_before = joints(running), refused(running)
    person = teleop("--speed", "0.5")
    person.wait_for("you drive arm, gripper")
    person.press("qqqq")
    person.wait_for("clutch out, holding")
    for count, _ in enumerate(running.client.joint_states()):
        if count == STILL_TICKS:
            break
    np.testing.assert_allclose(joints(running), start, atol=1e-3)

    person.press(" ")
    person.hold("q", lambda: joints(running)[0] - start[0] > 0.1, "the first joint moves")
    assert comes_to_rest(running) <= STILL_TICKS
    moved = joints(running) - start
    assert moved[0] > 0.1 and np.abs(moved[1:]).max() < 2e-3
    person.hold("a", lambda: joints(running)[0] < start[0], "it comes back")
    person.hold("v", lambda: "moving" in person.output, "the gripper's row is sent")
    assert "refused" not in person.output
    assert refused(running) == refused_before

    person.press("\x03")
    assert person.ended() == 130
    assert claims(running) == []
    assert running.client.gate_status().state == GateState.DISARMED


def tool(running: ScratchRobot) -> FloatArray:
    """Where the tool is in base_link [m]."""
    for batch in running.client.transforms():
        for one in batch.transforms:
            if (one.parent, one.child) == ("base_link", "grip_site"):
                return floats(one.translation)
    raise AssertionError


def test_a_tool_is_led_along_axes_and_what_the_gate_refuses_is_shown_with_units(
    running: ScratchRobot, teleop: Start
) -> None:
    start, refused_before = tool(running), refused(running)
    person = teleop("--mode", "cartesian_delta", "--speed", "1")
    person.wait_for("you drive arm, gripper")
    person.press(" ")
    person.hold("w", lambda: tool(running)[0] - start[0] > 0.08, "the tool goes ahead")
    comes_to_rest(running)
    np.testing.assert_allclose((tool(running) - start)[1:], 0.0, atol=5e-3)
    assert refused(running) == refused_before
    person.hold("f", lambda: "refused: G031" in person.output, "it is led into the table")
    assert re.search(
        r"refused: G031 [^:]+: arm \S.*: -?[\d.e-]+ m, limit -?[\d.e-]+ m", person.output
    )
    low = tool(running)
    person.hold("r", lambda: tool(running)[2] > low[2] + 0.05, "it is led out again")
    person.process.terminate()
    assert (person.ended(), claims(running)) == (130, [])


def test_a_terminal_that_is_closed_gives_the_parts_back_and_the_robot_holds(
    running: ScratchRobot, teleop: Start
) -> None:
    start = joints(running)
    person = teleop()
    person.wait_for("you drive arm, gripper")
    person.press(" ")
    person.hold("w", lambda: joints(running)[1] - start[1] > 0.05, "a joint moves")
    person.hang_up()
    wait_for(lambda: claims(running) == [], "the claim is released")
    assert comes_to_rest(running) <= STILL_TICKS
    person.ended()
    wait_for(lambda: running.client.gate_status().state == GateState.DISARMED, "disarmed again")


def test_a_killed_teleop_loses_its_claim_and_the_robot_comes_to_rest(
    running: ScratchRobot, teleop: Start
) -> None:
    start = joints(running)
    person = teleop()
    person.wait_for("you drive arm, gripper")
    person.press(" ")
    person.hold("w", lambda: joints(running)[1] - start[1] > 0.05, "a joint moves")
    person.process.send_signal(signal.SIGKILL)
    assert comes_to_rest(running) <= STILL_TICKS
    wait_for(lambda: claims(running) == [], "the claim ends without heartbeats")


def test_a_policy_is_taken_over_and_given_back_without_a_jump_and_each_turn_is_logged(
    running: ScratchRobot, teleop: Start
) -> None:
    states = running.client.joint_states(queue=2000)
    person = teleop("--over", "slow-reach", "--speed", "0.5")
    person.wait_for("slow-reach drives")
    start = joints(running)
    wait_for(lambda: np.abs(joints(running) - start).max() > 0.05, "the policy moves the arm")
    assert claims(running) == [("runner", ("arm", "gripper"))]
    person.press(" ")
    person.wait_for("you drive arm, gripper")
    wait_for(lambda: claims(running) == [("teleop", ("arm", "gripper"))], "the person has it")
    taken = joints(running)
    person.hold("w", lambda: joints(running)[1] - taken[1] > 0.05, "the person moves it")
    person.press("b")
    person.wait_for("slow-reach drives")
    wait_for(lambda: claims(running) == [("runner", ("arm", "gripper"))], "the policy has it")
    given = joints(running)
    wait_for(lambda: np.abs(joints(running) - given).max() > 0.05, "the policy goes on")
    person.press("x")
    person.wait_for("slow-reach cancelled")
    assert person.ended() == 0

    newest = running.client.gate_status().state_tick
    way = []
    while (state := states.next(1.0)) is not None and state.tick <= newest:
        way.append(floats(state.positions)[ARM])
    assert np.abs(np.diff(way, axis=0)).max() < STEP.max()
    gate = (running.scratch.state_dir / "logs/safety.log").read_text()
    turns = re.findall(r"claim \w+ of (\w+) for (.*), by \S+ \(fairlead teleop\)", gate)[-3:]
    assert turns == [
        ("runner", "slow-reach"),
        ("teleop", "teleop over slow-reach"),
        ("runner", "slow-reach"),
    ]


def test_a_skill_that_fails_ends_teleop_with_the_reason_and_exit_code_1(
    running: ScratchRobot, teleop: Start
) -> None:
    person = teleop("--over", "slow-reach")
    person.wait_for("slow-reach drives")
    wait_for(lambda: claims(running) == [("runner", ("arm", "gripper"))], "the policy has it")
    running.client.stop()
    person.wait_for("ERROR teleop: slow-reach failed: ")
    assert person.ended() == 1
    recover(running.client)


def test_a_jog_that_is_stopped_says_that_its_claim_is_lost(
    running: ScratchRobot, tmp_path: Path
) -> None:
    where = ("--deployment", str(running.scratch.file), "--speed", "0.02")
    person = terminal(tmp_path, "jog", *where, "elbow_joint", "60deg")
    wait_for(lambda: claims(running) == [("jog", ("arm",))], "it drives")
    running.client.stop()
    person.wait_for("ERROR claim of jog lost: the gate is stopped")
    assert person.ended() == 1
    recover(running.client)


def test_a_joint_is_jogged_and_the_robot_goes_home(running: ScratchRobot, tmp_path: Path) -> None:
    def do(*words: str) -> tuple[int, str]:
        where = ("--deployment", str(running.scratch.file), "--speed", "1")
        done = fairlead(words[0], *where, *words[1:], state=tmp_path)
        return done.returncode, done.stderr if done.returncode else done.stdout

    start = joints(running)
    code, said = do("jog", "elbow_joint", "-10deg")
    assert (code, said.splitlines()[-1]) == (0, "elbow_joint moved -0.1745 rad")
    np.testing.assert_allclose(joints(running)[2] - start[2], -np.pi / 18, atol=2e-3)
    before = tool(running)
    code, said = do("jog", "z", "30mm")
    assert code == 0 and re.search(r"^z moved 0\.0[23]\d+ m of 0\.0300 m: ", said), said
    np.testing.assert_allclose(tool(running) - before, [0, 0, 0.03], atol=4e-3)

    code, said = do("jog", "z", "-9")
    assert code == 1 and re.search(r"arm came no nearer.*; it has moved by x .*; G031 ", said)
    code, said = do("jog", "elbow_joint", "6")
    assert code == 1 and "; elbow_joint ends at 3.14" in said, said
    code, said = do("home")
    assert (code, said.splitlines()[-1]) == (0, "arm is home")
    assert ROBOT.home is not None
    rests = [ROBOT.home.positions[name] for name in ROBOT.part("arm").joints]
    np.testing.assert_allclose(joints(running), rests, atol=2e-3)
    assert running.client.gate_status().state == GateState.DISARMED
