"""A person moves an SO-101 leader arm: emulated servos lead, the gate judges, an arm follows.

The leader's horns are mounted anyhow; it was calibrated by the command, as a person does it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.emulated_arm import EmulatedArm, emulated_arm
from bench.equipment.live_robot import recover
from bench.equipment.terminal import Terminal
from fairlead.deploy.registry import Registry
from fairlead.messages import FloatArray, GateState, floats
from fairlead.paths import repo_root
from fairlead.robot.manifest import load_robot
from fairlead_tools.record.run_log import newest_log, read_run
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.cli.command import terminal
from tests.so101.arm import as_delivered
from tests.so101.calibrating import calibrate, move
from tests.teleop.slow_robot import slow_robot

pytestmark = [pytest.mark.processes, pytest.mark.timeout(200)]

ROBOT = load_robot("so101")
HOME = (0.0, -1.0, 0.9, 0.7, 0.0, 0.3)
STEP = np.array(ROBOT.profile("sim").parts["arm"].joint_position.step_limits)  # type: ignore[union-attr]
READ_RAD = 0.06
"""Gravity bends the hand's hold on the leader and the follower's servos; ends are read to 0.03."""
Start = Callable[..., Terminal]


class Leader:
    """An emulated arm with a person's hand on every joint, and its calibration."""

    def __init__(self, arm: EmulatedArm, file: Path) -> None:
        self.arm, self.file = arm, file

    def goes(self, *positions: float) -> None:
        for servo_id, position in enumerate(positions, start=1):
            self.arm.order(f"pull {servo_id} {position}")
        for servo_id, position in enumerate(positions, start=1):
            move(self.arm, servo_id, position)

    def healthy(self) -> None:
        for order in ("plug", "noise 0", "lose 0"):
            assert self.arm.order(order) == f"done: {order}"
        self.goes(*HOME)


@pytest.fixture(scope="module")
def leading(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Leader]:
    folder = tmp_path_factory.mktemp("leader")
    with emulated_arm(folder / "arm", "--mounting", "5") as arm:
        code, said = calibrate(arm, folder / "leader.yaml", "--arm", "leader")
        assert code == 0, said
        yield Leader(arm, folder / "leader.yaml")


@pytest.fixture
def leader(leading: Leader) -> Leader:
    leading.healthy()
    return leading


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ScratchRobot]:
    """A follower in MuJoCo, and a skill that takes its time."""
    folder = tmp_path_factory.mktemp("follower")
    with slow_robot(folder, "so101_mujoco", "so101-reach", 0.002) as robot:
        yield robot


@pytest.fixture
def teleop(running: ScratchRobot, leader: Leader, tmp_path: Path) -> Iterator[Start]:
    """Starts ``fairlead teleop`` with the leader where the episode begins."""
    recover(running.client)
    running.client.disarm()
    running.client.reset_episode(0)
    started: list[Terminal] = []

    def start(*arguments: str) -> Terminal:
        where = ("-d", str(running.scratch.file), "--device", "so101")
        what = ("--port", str(leader.arm.port), "--calibration", str(leader.file))
        started.append(terminal(tmp_path, "teleop", *where, *what, *arguments))
        return started[-1]

    yield start
    for person in started:
        person.end()


def joints(running: ScratchRobot) -> FloatArray:
    with running.client.joint_states(queue=1) as states:
        state = states.next(5.0)
    assert state is not None
    return floats(state.positions)


def comes_to_rest(running: ScratchRobot) -> FloatArray:
    """Where the joints stand still."""
    before = None
    for state in running.client.joint_states():
        now = floats(state.positions)
        if before is not None and np.abs(now - before).max() < 1e-4:
            return now
        before = now
    raise AssertionError


def is_at(running: ScratchRobot, *positions: float) -> Callable[[], bool]:
    return lambda: bool(np.abs(joints(running) - positions).max() < READ_RAD)


def test_the_follower_goes_where_the_leader_is_and_holds_without_the_clutch(
    running: ScratchRobot, leader: Leader, teleop: Start
) -> None:
    states = running.client.joint_states(queue=4000)
    person = teleop("--speed", "0.3")
    person.wait_for("you drive arm, gripper")
    there = (0.4, -0.7, 0.6, 0.9, 0.3, 0.3)
    leader.goes(*there)
    person.wait_for("clutch out, holding")
    np.testing.assert_allclose(comes_to_rest(running), HOME, atol=READ_RAD)

    person.press(" ")
    person.wait_for("aligning with the leader")
    person.wait_for("follows the leader")
    person.until(is_at(running, *there), "the follower is where the leader is")
    leader.goes(*HOME[:5], 1.2)
    person.until(is_at(running, *HOME[:5], 1.2), "it follows, and its jaw the trigger")

    person.press(" ")
    person.wait_for("clutch out, holding")
    held = comes_to_rest(running)
    leader.goes(*there)
    np.testing.assert_allclose(comes_to_rest(running), held, atol=2e-3)
    assert "refused" not in person.output
    person.press("x")
    assert person.ended() == 0
    assert running.client.gate_status().state == GateState.DISARMED
    newest = running.client.gate_status().state_tick
    way = []
    while (state := states.next(1.0)) is not None and state.tick <= newest:
        way.append(floats(state.positions)[:5])
    assert np.abs(np.diff(way, axis=0)).max() < STEP.max()


def test_what_the_gate_refuses_of_it_is_shown_and_the_way_back_is_free(
    running: ScratchRobot, leader: Leader, teleop: Start
) -> None:
    person = teleop("--speed", "1")
    person.wait_for("you drive arm, gripper")
    person.press(" ")
    person.wait_for("follows the leader")
    for servo_id, position in ((2, 0.9), (3, 0.6), (4, 0.9)):  # into the table
        leader.arm.order(f"pull {servo_id} {position}")
    refused = r"refused: G03\d [^:]+: \S.*: -?[\d.e-]+ m, limit"
    person.until(lambda: re.search(refused, person.output) is not None, "it is led into the table")
    leader.goes(*HOME)
    person.until(is_at(running, *HOME), "it is led out again")


@pytest.mark.parametrize(
    ("fault", "wrong"),
    [
        ("unplug 3", "servo 3 (elbow_flex), 4 (wrist_flex), 5 (wrist_roll), 6 (gripper) does not"),
        ("unplug 1", "no servo answers: bus cable out, or power off"),
        ("noise 1", "servo "),
        ("lose 1", "no servo answers: bus cable out, or power off"),
    ],
)
def test_a_leader_that_fails_is_named_and_nothing_moves_until_the_clutch_is_let_in_again(
    running: ScratchRobot, leader: Leader, teleop: Start, fault: str, wrong: str
) -> None:
    person = teleop()
    person.wait_for("you drive arm, gripper")
    person.press(" ")
    person.wait_for("follows the leader")
    leader.arm.order("pull 1 0.8")
    person.until(lambda: joints(running)[0] > 0.2, "it moves")
    leader.arm.order(fault)
    person.wait_for(f"leader: {wrong}")
    person.wait_for("clutch out, holding")
    held = comes_to_rest(running)
    leader.healthy()
    np.testing.assert_allclose(comes_to_rest(running), held, atol=2e-3)
    person.press(" ")
    person.wait_for("aligning with the leader")
    person.until(is_at(running, *HOME), "it goes on")


def who_moved(running: ScratchRobot) -> list[tuple[str, str]]:
    """Whose rows acted, one after the other and with holds between, by the decision log."""
    run = read_run(newest_log(running.scratch.state_dir))
    assert run.damage in ("", "not finished"), run.damage
    claims = {one.verdict_id: run.claims[one.claim_id] for _, one in run.verdicts if one.claim_id}
    turns: list[tuple[str, str]] = []
    for state in run.joints:
        moved = state.acted[0].verdict_id
        turn = (claims[moved].source, claims[moved].skill) if moved else ("nobody", "")
        if turns[-1:] != [turn]:
            turns.append(turn)
    return turns


def test_a_policy_is_taken_over_and_given_back_and_the_decision_log_has_every_turn(
    running: ScratchRobot, leader: Leader, teleop: Start
) -> None:
    states = running.client.joint_states(queue=4000)
    turns_before = len(who_moved(running))
    leader.goes(0.4, *HOME[1:])
    person = teleop("--over", "slow-reach")
    for _ in range(2):
        person.wait_for("slow-reach drives")
        start = joints(running)
        person.until(lambda at=start: np.abs(joints(running) - at).max() > 0.05, "the policy moves")  # type: ignore[misc]
        person.press(" ")
        person.wait_for("you drive arm, gripper")
        person.wait_for("follows the leader")
        person.until(lambda: abs(joints(running)[0] - 0.4) < READ_RAD, "the person has it")
        person.press("b")
    person.wait_for("slow-reach drives")
    person.press("x")
    person.wait_for("slow-reach cancelled")
    assert person.ended() == 0

    newest = running.client.gate_status().state_tick
    way = []
    while (state := states.next(1.0)) is not None and state.tick <= newest:
        way.append(floats(state.positions)[:5])
    assert np.abs(np.diff(way, axis=0)).max() < STEP.max()
    policy, person_over = ("runner", "slow-reach"), ("teleop", "teleop over slow-reach")
    nobody = ("nobody", "")
    turns = who_moved(running)[turns_before:]
    drove = [one for one, _ in groupby(turn for turn in turns if turn != nobody)]
    assert drove[:4] == [policy, person_over] * 2
    assert all(one == nobody or other == nobody for one, other in pairwise(turns)), turns


def test_servos_follow_servos_until_the_leaders_adapter_is_unplugged(tmp_path: Path) -> None:
    port, calibration = tmp_path / "follower/so101", as_delivered(tmp_path)
    options = f"port: {port}, calibration: {calibration}, answer_timeout_s: 0.2"
    text = (repo_root() / "compose/so101_mujoco.yaml").read_text()
    text = text.replace("run: hal_mujoco", f"run: hal_so101, options: {{{options}}}")
    (tmp_path / "servos.yaml").write_text(text)
    file = as_delivered(tmp_path, "leader")
    scratch = make_scratch(tmp_path / "servos.yaml", tmp_path / "up", ScratchOptions())
    with (
        emulated_arm(tmp_path / "leader") as arm,
        emulated_arm(tmp_path / "follower"),
        scratch_robot(scratch, Registry(tmp_path / "registry")) as robot,
        ExitStack() as at_end,
    ):
        where = ("-d", str(robot.scratch.file), "--device", "so101", "--port", str(arm.port))
        person = terminal(tmp_path, "teleop", *where, "--calibration", str(file))
        at_end.callback(person.end)
        person.wait_for("you drive arm, gripper")
        person.press(" ")
        person.wait_for("follows the leader")
        arm.order("pull 1 0.6")
        person.until(lambda: abs(joints(robot)[0] - 0.6) < READ_RAD, "the follower is there")
        arm.process.terminate()
        assert person.ended() == 1
        person.wait_for("is gone: adapter unplugged?")
        person.wait_for("; the robot holds")
        held = comes_to_rest(robot)
        assert abs(held[0] - 0.6) < READ_RAD
        assert robot.client.gate_status().claims == ()
