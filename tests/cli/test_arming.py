"""When ``run`` arms, asks and disarms, against a gate that is only its replies."""

from __future__ import annotations

import io
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import pytest
import typer

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.service_spec import ServiceSpec
from fairlead.errors import ConfigError, RefusedError
from fairlead.messages import (
    NO_HASH,
    ArmReply,
    ClaimInfo,
    Done,
    GateState,
    GateStatus,
    GoalFeedback,
    GoalResult,
    Message,
)
from fairlead.operate.client import RobotClient
from fairlead.wire.memory_bus import MemoryBus
from fairlead_tools.cli.arming import armed
from fairlead_tools.cli.episodes import new_episode
from fairlead_tools.cli.status import outside_warnings


class TerminalInput(io.StringIO):
    def isatty(self) -> bool:
        return True


SERVICES = {
    "hal": ServiceSpec(run="hal_sim"),
    "safety": ServiceSpec(run="safety"),
    "runner": ServiceSpec(run="skill_runner"),
}


ENDED = GoalResult(
    outcome="succeeded", decided_by="policy", kind="", detail="", first_tick=1, last_tick=2
)


@dataclass
class ScriptedGate:
    """Answers arm, disarm and status; remembers what it was asked."""

    state: GateState = GateState.DISARMED
    profile: str = "sim"
    claims: tuple[ClaimInfo, ...] = ()
    is_busy: bool = False
    is_interrupted_by_arming: bool = False
    is_interrupted_by_leaving: bool = False
    goal_id: int = 0
    goal_result: GoalResult | None = None
    asked: list[str] = field(default_factory=list)
    runner_dies: list[Callable[[], None]] = field(default_factory=list)

    def arm(self, payload: bytes) -> Message:
        self.asked.append("arm")
        self.state = GateState.ARMED
        if self.is_interrupted_by_arming:
            signal.raise_signal(signal.SIGINT)
        return ArmReply(epoch=1, session=1)

    def disarm(self, payload: bytes) -> Message:
        self.asked.append("disarm")
        self.state = GateState.DISARMED
        return Done(text="disarmed")

    def feedback(self, payload: bytes) -> Message:
        """Of the runner beside it."""
        return GoalFeedback(
            source="runner", goal_id=self.goal_id, skill="s", phase="", tick=0, queue_depth=0,
            inferences=0, starved=0, last_refusal="", result=self.goal_result,
        )  # fmt: skip

    def status(self, payload: bytes) -> Message:
        if self.is_busy:
            raise RefusedError("safety", "busy")
        if self.is_interrupted_by_leaving:
            self.is_interrupted_by_leaving = False
            signal.raise_signal(signal.SIGINT)
        return GateStatus(
            robot="r", profile=self.profile, session=1, epoch=1, state=self.state, cause="", fix="",
            latch_id=0, stop_ids=(), claims=self.claims, counters=(), state_tick=1,
            lockstep_allowed=True, config_hash=NO_HASH, robot_hash=NO_HASH,
        )  # fmt: skip


@pytest.fixture
def gate() -> ScriptedGate:
    return ScriptedGate()


@pytest.fixture
def clients(gate: ScriptedGate) -> Iterator[dict[str, RobotClient]]:
    """A client for each profile."""
    found = {}
    for profile in ("sim", "hardware"):
        deployment = Deployment.model_validate(
            {"robot": "r", "id": "r", "profile": profile, "services": SERVICES}
        )
        bus, keys = MemoryBus(), deployment.keys
        for name in ("hal", "safety"):
            bus.declare_token(keys.alive(name))
        bus.serve(keys.gate_command("arm"), "safety", gate.arm)
        bus.serve(keys.gate_command("disarm"), "safety", gate.disarm)
        bus.serve(keys.gate_status, "safety", gate.status)
        gate.runner_dies.append(bus.declare_token(keys.alive("runner")).undeclare)
        bus.serve(keys.feedback("runner"), "runner", gate.feedback)
        found[profile] = RobotClient(deployment, bus)
    yield found
    for client in found.values():
        client.close()


def other_claim() -> ClaimInfo:
    return ClaimInfo(source="other", skill="s", claim_id=5, parts=("base",))


def test_a_robot_s_file_that_was_spoiled_is_a_warning_of_status(
    clients: dict[str, RobotClient],
) -> None:
    [warning] = outside_warnings(clients["sim"])
    assert "'r'" in warning, warning


def test_a_disarmed_simulator_is_armed_and_disarmed_again(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    with armed(clients["sim"]):
        assert gate.state is GateState.ARMED
    assert gate.asked == ["arm", "disarm"]


def test_an_armed_robot_is_left_as_it_was(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    gate.state = GateState.ARMED
    with armed(clients["sim"]):
        pass
    assert gate.asked == []


def test_it_disarms_also_when_the_goal_fails(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    with pytest.raises(RuntimeError), armed(clients["sim"]):
        raise RuntimeError("goal failed")
    assert gate.asked == ["arm", "disarm"]


def test_a_gate_that_refuses_to_answer_then_does_not_hide_why_the_goal_failed(
    gate: ScriptedGate, clients: dict[str, RobotClient], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ConfigError, match="goal failed"), armed(clients["sim"]):
        gate.is_busy = True
        raise ConfigError("goal failed")
    assert capsys.readouterr().err == "not disarmed: safety refused: busy\n"


def test_ctrl_c_while_it_arms_leaves_nothing_armed(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    gate.is_interrupted_by_arming = True
    with pytest.raises(KeyboardInterrupt), armed(clients["sim"]):
        pytest.fail("it was interrupted before")
    assert gate.asked == ["arm", "disarm"]


def test_ctrl_c_while_it_disarms_leaves_nothing_armed(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    with pytest.raises(KeyboardInterrupt), armed(clients["sim"]):
        gate.is_interrupted_by_leaving = True
    assert gate.asked == ["arm", "disarm"]


def test_it_does_not_disarm_under_another_claim(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    with armed(clients["sim"]):
        gate.claims = (other_claim(),)
    assert gate.asked == ["arm"]


def test_it_disarms_under_the_claim_of_a_runner_that_has_died(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    with armed(clients["sim"]):
        gate.goal_id = 7
        gate.claims = (ClaimInfo(source="runner", skill="s", claim_id=5, parts=("base",)),)
        for die in gate.runner_dies:
            die()
    assert gate.asked == ["arm", "disarm"]


def test_it_disarms_under_a_claim_that_a_runner_without_a_goal_has_left(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    with armed(clients["sim"]):
        gate.goal_id, gate.goal_result = 7, ENDED
        gate.claims = (ClaimInfo(source="runner", skill="s", claim_id=5, parts=("base",)),)
    assert gate.asked == ["arm", "disarm"]


def test_no_new_episode_under_a_goal_that_has_not_claimed_yet(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    gate.goal_id = 7
    with pytest.raises(RefusedError, match="would be under the goal of runner, which runs s"):
        new_episode(clients["sim"], 7)
    assert gate.asked == []


@pytest.mark.parametrize("has_ended", [False, True])
def test_it_does_not_disarm_under_a_goal_that_has_not_claimed_yet(
    has_ended: bool, gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    with armed(clients["sim"]):
        gate.goal_id = 7
        gate.goal_result = ENDED if has_ended else None
    assert gate.asked == (["arm", "disarm"] if has_ended else ["arm"])


@pytest.mark.parametrize("state", [GateState.STOPPED, GateState.LATCHED, GateState.DISARMED])
def test_it_does_not_disarm_what_is_no_longer_armed(
    state: GateState, gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    with armed(clients["sim"]):
        gate.state = state
    assert gate.asked == ["arm"]


@pytest.mark.parametrize("meanwhile", [GateState.DISARMED, GateState.ARMED])
def test_without_a_yes_hardware_is_not_armed_nor_disarmed_that_somebody_else_has_armed_meanwhile(
    meanwhile: GateState,
    gate: ScriptedGate,
    clients: dict[str, RobotClient],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def no(text: str, abort: bool, err: bool) -> None:
        assert text == "The robot is real and will move. Arm it?" and abort and err
        gate.state = meanwhile
        raise typer.Abort

    monkeypatch.setattr("typer.confirm", no)
    monkeypatch.setattr("sys.stdin", TerminalInput())
    with pytest.raises(typer.Abort), armed(clients["hardware"]):
        pass
    assert gate.asked == []


def test_hardware_is_armed_when_confirmed_on_the_command_line(
    gate: ScriptedGate, clients: dict[str, RobotClient]
) -> None:
    with armed(clients["hardware"], confirmed=True):
        assert gate.state is GateState.ARMED
    assert gate.asked == ["arm", "disarm"]


def test_a_gate_that_runs_a_hardware_profile_asks_whatever_the_deployment_file_says(
    gate: ScriptedGate, clients: dict[str, RobotClient], monkeypatch: pytest.MonkeyPatch
) -> None:
    gate.profile = "hardware"
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    with pytest.raises(RefusedError, match="no terminal to ask at"), armed(clients["sim"]):
        pass
    assert gate.asked == []
