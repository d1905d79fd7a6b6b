"""Who commands a robot is a person whose certificate says so, where its file lists people."""

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
from pydantic import ValidationError

from bench.equipment.live_robot import wait_for
from bench.faults.live_stage import LiveStage
from bench.faults.routed_stage import certified_stage
from fairlead.deploy.access import rights
from fairlead.deploy.certificates import certificates_dir
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError, FairleadError, NoAnswerError, RefusedError
from fairlead.keys import of_person
from fairlead.messages import (
    NO_HASH,
    Arm,
    Cancel,
    Disarm,
    GateState,
    Goal,
    Load,
    Message,
    Reset,
    ResetEpisode,
)
from fairlead.operate.asker import OPERATOR_VARIABLE, asker, person_here
from fairlead.operate.client import RobotClient
from fairlead.paths import ACCESS_VARIABLE, ROBOTS_VARIABLE, repo_root, robot_dir
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import load_robot
from fairlead.wire.session import ZenohBus
from fairlead_tools.certificates.authority import Authority
from tests.cli.command import fairlead, fairlead_here

ONE_HOST = repo_root() / "compose" / "panda_mobile_sim.yaml"
PEOPLE = ["ada", "ben"]
CAREFUL = "careful"
ANSWER_S = 0.5


@pytest.fixture
def file(file: Path) -> Path:
    """The same with people."""
    content = yaml.safe_load(file.read_text(encoding="utf-8")) | {"people": PEOPLE}
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return file


def changed(file: Path, **changes: object) -> Deployment:
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    return Deployment.model_validate(content | changes)


@pytest.mark.parametrize(
    ("people", "problem"),
    [
        (["ada", "ada"], "people: ada: another has this name; each person needs an own one"),
        (["gpu"], "people: gpu: another has this name"),
        (["runner"], "people: runner: another has this name"),
        (["operator"], "operator: tools have this name"),
        (["ada.l"], "people: 'ada.l': expected a name of a-z 0-9 _ -"),
        (["a" * 60], "longer than the 64 signs that a certificate can name"),
    ],
)
def test_a_name_that_is_another_s_or_none_is_refused(
    file: Path, people: list[str], problem: str
) -> None:
    with pytest.raises(ValidationError, match=re.escape(problem)):
        changed(file, people=people)


def test_on_one_host_nothing_proves_a_person(file: Path) -> None:
    content = yaml.safe_load(ONE_HOST.read_text(encoding="utf-8")) | {"people": PEOPLE}
    with pytest.raises(ValidationError, match="certificates prove them, which are for hosts and a"):
        Deployment.model_validate(content)
    assert changed(file, access="open").parties.people == ()


def test_commands_are_a_persons_and_all_else_stays_the_tools(file: Path) -> None:
    listed = {(one.key, one.kind): one.write for one in rights(load_deployment(file).parties)}
    nobody = {(one.key, one.kind): one.write for one in rights(changed(file, people=[]).parties)}
    robot = "fl/certified"
    commands = ["safety/cmd/arm", "safety/cmd/disarm", "safety/cmd/reset", "hal/cmd/reset_episode"]
    commands += [f"skill/runner/{verb}" for verb in ("goal", "cancel", "load")]
    for command in commands:
        key = f"{robot}/{command}"
        assert (key, "query") not in listed
        assert nobody.pop((key, "query")) == ["operator"]
        for person in PEOPLE:
            assert listed.pop((f"{key}/{person}", "query")) == [person]
    assert listed.keys() == nobody.keys()
    for one, names in nobody.items():
        assert listed[one] == [*names, *(PEOPLE if "operator" in names else ())]


def test_each_person_has_a_certificate_in_a_folder_of_their_own(file: Path, tmp_path: Path) -> None:
    def certs(*words: str) -> str:
        done = fairlead_here("certs", words[0], str(file), *words[1:], state=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout

    made = certs("new")
    assert "ada/ada, ben/ben" in made
    folder = certificates_dir(load_deployment(file).keys)
    assert (
        "ada needs, in an account that nobody else uses, at the same place below its home" in made
    )
    assert f"the folder {folder / 'ada'}: whoever can read it is ada\n" in made
    assert {one.name for one in (folder / "ada").iterdir()} == {"ada.pem", "router.ca"}
    assert not (folder / "gpu" / "ada.pem").exists()
    assert certs("renew", "ada").startswith("renewed ada/ada\n")
    assert certs("revoke", "ben").startswith("revoked ben/ben\n")
    shown = {line.split()[1]: line.split("UTC")[-1].split() for line in certs("show").splitlines()}
    assert (shown["ada"], shown["ben"][-2:]) == (["valid"], ["none", "here"])


def test_who_has_left_the_list_is_revoked(authority: Authority, file: Path) -> None:
    assert Authority(changed(file, people=["ada"])).left == [("ben", "ben")]
    assert authority.left == []


def account(folder: Path, deployment: Deployment, *names: str) -> Path:
    """A folder of certificates as an account has it, with these of all there are."""
    made = certificates_dir(deployment.keys)
    own = folder / "-".join(names)
    for name in names:
        shutil.copytree(made / name, own / deployment.id / "certificates" / name)
    for path in own.rglob("*"):
        path.chmod(0o700 if path.is_dir() else 0o600)
    return own


HERE: dict[str, tuple[tuple[str, ...], str | None, str, str]] = {
    "ada's alone": (("ada",), None, "mia", "ada"),
    "ada's, who says so": (("ada",), "ada", "mia", "ada"),
    "both, ben's user": (("ada", "ben"), None, "ben", "ben"),
    "both, ben is named": (("ada", "ben"), "ben", "ada", "ben"),
    "both, and another user": (("ada", "ben"), None, "mia", ""),
    "nobody's": (("gpu",), None, "ada", ""),
}


@pytest.mark.parametrize("situation", HERE)
def test_tools_are_the_person_whose_certificate_is_here(
    situation: str, authority: Authority, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names, named, user, expected = HERE[situation]
    monkeypatch.setenv(ACCESS_VARIABLE, str(account(tmp_path, authority.deployment, *names)))
    monkeypatch.setattr("getpass.getuser", lambda: user)
    monkeypatch.delenv(OPERATOR_VARIABLE, raising=False)
    if named is not None:
        monkeypatch.setenv(OPERATOR_VARIABLE, named)
    assert person_here(authority.deployment) == expected
    assert asker(authority.deployment, "x").startswith(f"{expected or user}@")


@pytest.mark.parametrize("named", ["ben", "mia"])
def test_no_tool_says_another_name_than_its_certificates(
    named: str, authority: Authority, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ACCESS_VARIABLE, str(account(tmp_path, authority.deployment, "ada")))
    monkeypatch.setenv(OPERATOR_VARIABLE, named)
    said = (
        f"FAIRLEAD_OPERATOR: deployment certified: expected a person whose certificate is here, "
        f"got {named} (valid: ada)"
    )
    with pytest.raises(ConfigError, match=re.escape(said)):
        RobotClient(authority.deployment)


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


def every_command(robot: LiveStage, by: str) -> dict[str, tuple[str, Message]]:
    """By key, with who answers."""
    keys = robot.client.keys
    return {
        keys.gate_command("arm"): ("safety", Arm(by=by)),
        keys.gate_command("disarm"): ("safety", Disarm(by=by)),
        keys.gate_command("reset"): ("safety", Reset(by=by, id=1)),
        keys.hal_command("reset_episode"): ("hal", ResetEpisode(seed=1, by=by)),
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


@pytest.mark.processes
@pytest.mark.timeout(240)
def test_what_ada_forges_of_ben_goes_nowhere_or_is_refused_and_logged(robot: LiveStage) -> None:
    with closing(thief(robot)) as bus:
        for key, (service, request) in every_command(robot, "ben@lab (x)").items():
            for anothers in (key, of_person(key, "ben")):
                with pytest.raises(NoAnswerError):
                    bus.query(anothers, request, ANSWER_S)
            before = refusals(robot, service)
            with pytest.raises(RefusedError, match=f"^{service} refused: {FORGED}"):
                bus.query(of_person(key, "ada"), request, 10.0)
            wait_for(partial(logged_after, robot, service, before), "it is logged")
    assert robot.client.gate_status().state == GateState.DISARMED


@pytest.mark.processes
@pytest.mark.timeout(240)
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


@pytest.mark.processes
@pytest.mark.timeout(240)
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
