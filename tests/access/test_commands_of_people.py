"""Commands of people to a robot that runs: nobody gives them in another's name."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from signal import SIGKILL

import pytest
import yaml

from bench.equipment.live_robot import wait_for
from bench.faults.live_stage import LiveStage
from bench.faults.routed_stage import certified_stage
from fairlead.errors import FairleadError, NoAnswerError, RefusedError
from fairlead.keys import of_person
from fairlead.messages import (
    NO_HASH,
    Arm,
    Cancel,
    Claim,
    Disarm,
    GateState,
    Goal,
    Load,
    Message,
    Reset,
    ResetEpisode,
)
from fairlead.operate.asker import OPERATOR_VARIABLE
from fairlead.paths import ACCESS_VARIABLE, ROBOTS_VARIABLE, robot_dir
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import load_robot
from fairlead.wire.session import ZenohBus
from tests.access.certified import PEOPLE, account
from tests.cli.command import fairlead_here as fairlead

pytestmark = [pytest.mark.processes, pytest.mark.timeout(240)]

CAREFUL = "careful"
ANSWER_S = 0.5


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    """A robot whose latch two persons reset; this process is ada's."""
    folder = tmp_path_factory.mktemp("people")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(ROBOTS_VARIABLE, str(folder / "robots"))
        patch.setenv(ACCESS_VARIABLE, str(folder / "access"))
        patch.setenv(OPERATOR_VARIABLE, "ada")
        careful_robot(folder / "robots" / CAREFUL)
        with certified_stage(folder / "stage", robot=CAREFUL, people=PEOPLE) as stage:
            yield stage


def careful_robot(folder: Path) -> None:
    shutil.copytree(robot_dir("panda_mobile"), folder)
    manifest = folder / "robot.yaml"
    content = yaml.safe_load(manifest.read_text(encoding="utf-8")) | {"id": CAREFUL}
    content["safety"]["sim"]["protocol"]["second_person_s"] = 3600
    manifest.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    compiled = compile_gate_config(load_robot(CAREFUL), "sim")
    (folder / "gate.sim.json").write_text(compiled, encoding="utf-8")


def log_of(robot: LiveStage, service: str) -> str:
    return (robot.supervisor.state_dir / "logs" / f"{service}.log").read_text(encoding="utf-8")


def thief(robot: LiveStage) -> ZenohBus:
    """With ada's certificate, keeping to no rule."""
    one = robot.client.deployment.tool_endpoints("ada")
    proof = {name: part for name, part in one.access.items() if name == "transport"}
    return ZenohBus(replace(one, access=proof))


def a_claim(source: str, by: str) -> Claim:
    return Claim(
        source=source, skill="s", skill_hash=NO_HASH, robot_hash=NO_HASH, period_ns=1,
        parts=("arm",), chunk_rate_hz=1.0, horizon_max=1, age_max_ticks=1, limits=(), by=by,
    )  # fmt: skip


def every_command(robot: LiveStage, by: str) -> dict[str, tuple[str, Message]]:
    """By key, with who answers."""
    keys = robot.client.keys
    return {
        keys.gate_command("arm"): ("safety", Arm(by=by)),
        keys.gate_command("disarm"): ("safety", Disarm(by=by)),
        keys.gate_command("reset"): ("safety", Reset(by=by, id=1)),
        keys.hal_command("reset_episode"): ("hal", ResetEpisode(seed=1, by=by)),
        keys.claim("x"): ("safety", a_claim("x", by)),
        keys.goal("runner"): (
            "runner",
            Goal(skill="x", skill_hash=NO_HASH, prompt="", deadline_ticks=0, stall_timeout_s=1.0,
                 by=by),
        ),
        keys.cancel("runner"): ("runner", Cancel(goal_id=1, by=by)),
        keys.load("runner"): ("runner", Load(skill="x", by=by)),
    }  # fmt: skip


FORGED = "asked in the name of ben on the key of ada"


def refusals(robot: LiveStage, service: str) -> int:
    return log_of(robot, service).count(f"refused a query: {FORGED}")


def logged_after(robot: LiveStage, service: str, before: int) -> bool:
    return refusals(robot, service) > before


def test_what_ada_forges_of_ben_goes_nowhere_or_is_refused_and_logged(robot: LiveStage) -> None:
    with closing(thief(robot)) as bus:
        for key, (service, request) in every_command(robot, "ben@lab (x)").items():
            for anothers in (key, of_person(key, "ben"), of_person(key, "*")):
                with pytest.raises(NoAnswerError):
                    bus.query(anothers, request, ANSWER_S)
            before = refusals(robot, service)
            with pytest.raises(RefusedError, match=f"^{service} refused: {FORGED}"):
                bus.query(of_person(key, "ada"), request, 10.0)
            wait_for(partial(logged_after, robot, service, before), "it is logged")
        runners = of_person(robot.client.keys.claim("runner"), "ada")
        with pytest.raises(NoAnswerError):
            bus.query(runners, a_claim("runner", "ada@lab (x)"), ANSWER_S)
    assert robot.client.gate_status().state == GateState.DISARMED


def test_what_a_person_claims_is_logged_by_the_name_in_the_certificate(robot: LiveStage) -> None:
    robot.ready_to_move()
    with robot.client.claim(["base"], source="teleop"):
        pass
    robot.client.disarm()
    said = re.compile(r"claim [0-9a-f]{16} of teleop for teleop, by ada@robot \(")
    wait_for(lambda: said.search(log_of(robot, "safety")) is not None, "the log names who claims")


def test_a_latch_is_reset_by_two_who_prove_that_they_are_two(
    robot: LiveStage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    client, deployment = robot.client, robot.client.deployment
    if client.gate_status().state == GateState.DISARMED:  # run again it is not
        client.arm()
    wait_for(lambda: "armed by ada@robot (" in log_of(robot, "safety"), "the log names who armed")
    robot.signal("safety", SIGKILL)
    robot.restarted("safety")
    latch_id = client.wait_gate_follows(60.0).latch_id

    def reset(account_of: str, named: str | None = None) -> str:
        """Of the command in an account that has only these certificates."""
        with monkeypatch.context() as patch:
            patch.setenv(ACCESS_VARIABLE, str(accounts[account_of]))
            patch.delenv(OPERATOR_VARIABLE)
            if named is not None:
                patch.setenv(OPERATOR_VARIABLE, named)
            file = str(robot.robot.scratch.file)
            done = fairlead("reset", f"{latch_id:016x}", "--deployment", file, state=tmp_path)
            return done.stdout + done.stderr

    accounts = {one: account(tmp_path, deployment, one) for one in (*PEOPLE, "robot")}
    waits = "asked to reset the latch; another person has to ask too"
    wait_for(lambda: waits in reset("ada"), "the gate hears of a robot that stands still")
    assert "a person whose certificate is here, got ben (valid: ada)" in reset("ada", "ben")
    with closing(thief(robot)) as bus:
        key = client.keys.gate_command("reset")
        for one in (key, of_person(key, "ada"), of_person(key, "ben")):
            with pytest.raises(FairleadError):
                bus.query(one, Reset(by="ben@lab (x)", id=latch_id), ANSWER_S)
    assert "needs the certificate of one of ada, ben, and none is here" in reset("robot")
    assert client.gate_status().state == GateState.LATCHED
    assert f"{latch_id:016x} was reset" in reset("ben")
    both = re.compile(r"was reset by ada@\S+ \(fairlead\) and ben@")
    wait_for(lambda: both.search(log_of(robot, "safety")) is not None, "the log names both")
    assert client.gate_status().state == GateState.DISARMED


def test_anybodys_tool_looks_on_and_stops_and_the_person_resets(
    robot: LiveStage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    deployment = robot.client.deployment
    monkeypatch.setenv(ACCESS_VARIABLE, str(account(tmp_path, deployment, "robot")))
    file = str(robot.robot.scratch.file)
    monkeypatch.setenv(OPERATOR_VARIABLE, "mia")
    stopped = fairlead("stop", "--deployment", file, state=tmp_path)
    assert stopped.returncode == 0, stopped.stderr
    assert "got mia (valid: none); stopping all the same" in stopped.stderr
    monkeypatch.delenv(OPERATOR_VARIABLE)
    assert fairlead("status", "--deployment", file, state=tmp_path).returncode == 0
    [stop_id] = robot.client.gate_status().stop_ids
    robot.client.reset(stop_id)
    assert robot.client.gate_status().state == GateState.DISARMED
