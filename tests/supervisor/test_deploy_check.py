"""`fairlead deploy check`: mistakes on every host are found before anything starts."""

from __future__ import annotations

import json
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ServiceError
from fairlead.paths import repo_root
from fairlead_tools.deploy.all_hosts import ask_host, compare
from fairlead_tools.deploy.host_report import HostReport
from fairlead_tools.supervisor.this_host import free_ports
from tests.cli.command import fairlead_command, fairlead_environment, fairlead_here
from tests.supervisor.two_hosts_file import content
from tests.system.two_networks import TwoNetworks, two_networks

REPORT = HostReport(
    host="robot",
    processes=["router", "hal", "safety", "state_assembler"],
    versions={"fairlead": "0.1.0", "eclipse-zenoh": "1.10.2"},
    file="f1",
    robot="r1",
    skills={"pick": "s1", "drive": "s2"},
    trusted="m1",
    clock_s=1e9,
    problems=[],
    warnings=[],
)
DIFFERENT: dict[str, tuple[dict[str, Any], str]] = {
    "nothing": ({}, ""),
    "a skill fewer": ({"skills": {"pick": "s1"}}, ""),
    "a little later": ({"clock_s": 1e9 + 100}, ""),
    "version": (
        {"versions": {"fairlead": "0.2.0", "eclipse-zenoh": "1.10.2"}},
        "hosts robot and gpu have fairlead 0.1.0 and 0.2.0: install the same on both",
    ),
    "file": ({"file": "f2"}, "hosts robot and gpu have different deployment files: copy it"),
    "robot": ({"robot": "r2"}, "different robots panda_mobile: copy robots/panda_mobile from"),
    "certificates": ({"trusted": "m2"}, "certificates of different makes: fairlead certs new on"),
    "clock": ({"clock_s": 1e9 + 7200}, "hosts robot and gpu have clocks 2.0 h apart: set them"),
    "skill": ({"skills": {"pick": "s3"}}, "skill pick is s3 on host gpu and s1 on host robot: "),
    "a skill more": ({"skills": {"own": "s3"}}, "skill own is s3 on host gpu and none on host "),
}


@pytest.mark.parametrize("what", DIFFERENT)
def test_what_has_to_be_the_same_on_all_hosts_is_compared(what: str, tmp_path: Path) -> None:
    changed, expected = DIFFERENT[what]
    file = tmp_path / "two.yaml"
    file.write_text(yaml.safe_dump(content()), encoding="utf-8")
    other = REPORT.model_copy(update={"host": "gpu"} | changed)
    found = list(compare(load_deployment(file), [REPORT, other]))
    assert len(found) == bool(expected) and all(expected in text for text in found), found


@pytest.mark.processes
def test_a_host_that_answers_in_two_lines_is_a_problem_of_one(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(yaml.safe_dump(content(hosts={"robot": "10.77.0.8", "gpu": "10.77.0.9"})))
    reach = "sh -c 'echo banner; echo timed out' {address}"
    with pytest.raises(ServiceError, match="cannot be asked: banner; timed out; by hand, there: "):
        ask_host(file, load_deployment(file), "gpu", reach, "fairlead")


def test_hosts_without_a_runner_or_an_assembler_are_compared_too(tmp_path: Path) -> None:
    spec = content()
    del spec["services"]["state_assembler"], spec["services"]["runner"]
    file = tmp_path / "bare.yaml"
    file.write_text(yaml.safe_dump(spec), encoding="utf-8")
    other = REPORT.model_copy(update={"host": "gpu", "skills": {"pick": "s3"}})
    assert list(compare(load_deployment(file), [REPORT, other])) == []


def check(
    network: TwoNetworks, file: Path, *more: str
) -> tuple[int, dict[str, HostReport], list[str]]:
    """As on the robot's host: the other one is asked as by ssh, through its namespace."""
    words = ["deploy", "check", str(file), "--json", "--program", shlex.join(fairlead_command())]
    words += ["--reach", shlex.join([*network.on("gpu"), "env", "ASKED_AT={address}"])]
    done = subprocess.run(
        [*network.on("robot"), *fairlead_command(*words, *more)],
        env=fairlead_environment(file.parent), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.stderr == "", done.stderr
    answer = json.loads(done.stdout)
    reports = [HostReport.model_validate(one) for one in answer["hosts"]]
    return done.returncode, {one.host: one for one in reports}, answer["problems"]


@pytest.mark.processes
def test_two_hosts_are_asked_and_each_mistake_is_said_with_its_fix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_ACCESS", str(tmp_path / "access"))
    with two_networks() as network:
        file, port = tmp_path / "two.yaml", free_ports(1)[0]
        router = {"host": "robot", "port": port}
        spec = content(hosts=network.addresses, router=router)
        file.write_text(yaml.safe_dump(spec), encoding="utf-8")

        code, reports, problems = check(network, file)
        assert code == 1 and problems == []
        assert "router: no certificate " in reports["robot"].problems[0]
        assert "fairlead certs new" in reports["gpu"].problems[0]

        made = fairlead_here("certs", "new", str(file), state=tmp_path)
        assert made.returncode == 0, made.stderr
        code, reports, problems = check(network, file)
        assert (code, problems) == (0, []), reports
        assert reports["robot"].skills == reports["gpu"].skills != {}

        here = f"import socket, sys; s = socket.create_server(('{network.addresses['robot']}', "
        here += f"{port})); print('listens', flush=True); sys.stdin.read()"
        with subprocess.Popen(
            [*network.on("robot"), sys.executable, "-c", here],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        ) as other:  # fmt: skip
            assert other.stdout is not None and other.stdout.readline() == b"listens\n"
            code, reports, _ = check(network, file)
            other.communicate()
        assert code == 1 and f"its port {port} is taken by pid " in reports["robot"].problems[0]

        if not network.why_loopback:
            nobody = network.addresses | {"gpu": "10.77.0.9"}
            file.write_text(yaml.safe_dump(spec | {"hosts": nobody}), encoding="utf-8")
            code, reports, problems = check(network, file)
            assert code == 1 and "10.77.0.9 is none of this machine's" in reports["gpu"].problems[0]


@pytest.mark.processes
def test_a_robot_and_a_skill_that_one_of_two_hosts_has_otherwise_are_named(
    tmp_path: Path,
) -> None:
    """Both are asked; the other one has a copy of robots and skills."""
    other = tmp_path / "gpu"
    for folder in ("robots", "rskills"):
        shutil.copytree(repo_root() / folder, other / folder)
    with two_networks() as network:
        file = tmp_path / "two.yaml"
        router = {"host": "robot", "port": free_ports(1)[0]}
        spec = content(hosts=network.addresses, router=router, access="open")
        file.write_text(yaml.safe_dump(spec), encoding="utf-8")
        root = f"FAIRLEAD_ROOT={other}"
        reach = ["--reach", shlex.join([*network.on("gpu"), "env", root, "ASKED_AT={address}"])]
        code, _, problems = check(network, file, *reach)
        assert (code, problems) == (0, [])
        for changed, old, new in (
            ("robots/panda_mobile/robot.yaml", "control_period_ms: 50", "control_period_ms: 40"),
            ("rskills/go-to/rskill.yaml", "version: 0.1.0", "version: 0.1.1"),
        ):
            text = (other / changed).read_text(encoding="utf-8")
            assert old in text
            (other / changed).write_text(text.replace(old, new), encoding="utf-8")
        code, _, problems = check(network, file, *reach)
        assert code == 1
        assert any("have different robots panda_mobile: copy robots/" in one for one in problems)
        assert any(one.startswith("skill go-to is ") for one in problems), problems


@pytest.mark.processes
@pytest.mark.parametrize(
    ("robot", "port", "wrong"),
    [
        ("left", 7502, "left and left have the same id; each robot needs its own"),
        ("right", 7501, "left and right both listen on port 7501 (hal, hal); give one another"),
        ("r", 7502, ""),
    ],
)
def test_several_files_of_one_machine_find_what_two_robots_cannot_share(
    robot: str, port: int, wrong: str, tmp_path: Path
) -> None:
    files = [tmp_path / "one.yaml", tmp_path / "other.yaml"]
    for file, (name, number) in zip(files, (("left", 7501), (robot, port)), strict=True):
        listen = {"hal": number, "safety": number + 10}
        services = {
            one: {"run": run, "listen": f"tcp/127.0.0.1:{listen[one]}"}
            for one, run in (("hal", "hal_mujoco"), ("safety", "safety"))
        }
        spec = {"robot": "panda", "id": name, "access": "open", "services": services}
        file.write_text(yaml.safe_dump(spec), encoding="utf-8")
    done = fairlead_here("deploy", "check", *map(str, files), state=tmp_path)
    assert (f"PROBLEM {wrong}" in done.stdout) == bool(wrong), done.stdout + done.stderr


@pytest.mark.processes
def test_another_version_on_a_host_is_named_also_where_its_answer_has_other_fields(
    tmp_path: Path,
) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(yaml.safe_dump(content(access="open")), encoding="utf-8")
    other = tmp_path / "fairlead-0.2.0.dist-info"
    other.mkdir()
    (other / "METADATA").write_text("Metadata-Version: 2.1\nName: fairlead\nVersion: 0.2.0\n")

    def asked(*words: str) -> str:
        reach = ["--reach", shlex.join([*words, "ASKED_AT={address}"])]
        program = ["--program", shlex.join(fairlead_command())]
        done = fairlead_here("deploy", "check", str(file), *reach, *program, state=tmp_path)
        assert done.returncode == 1
        return done.stdout

    said = asked("env", f"PYTHONPATH={tmp_path}")
    assert "PROBLEM hosts gpu and robot have fairlead 0.2.0 and 0.1.0: install the same on" in said
    answer = tmp_path / "answer.json"
    answer.write_text('{"hosts": [{"versions": {"fairlead": "0.2.0"}, "later": 1}]}')
    said = asked("sh", "-c", f"cat {answer}")
    assert (
        "PROBLEM host gpu: answers as another version does: it has fairlead 0.2.0, this machine "
        "0.1.0: install the same on both" in said
    )


@pytest.mark.parametrize(
    ("robot", "port", "wrong"), [("left", 7448, "id"), ("right", 7447, "router.port"), ("r", 1, "")]
)
def test_several_files_find_robots_that_cannot_share_their_router(
    robot: str, port: int, wrong: str, tmp_path: Path
) -> None:
    files = [tmp_path / "one.yaml", tmp_path / "other.yaml"]
    for file, (name, number) in zip(files, (("left", 7447), (robot, port)), strict=True):
        spec = content(access="open", id=name, router={"host": "robot", "port": number})
        file.write_text(yaml.safe_dump(spec), encoding="utf-8")
    done = fairlead_here("deploy", "check", *map(str, files), "--host", "gpu", state=tmp_path)
    said = f"PROBLEM router: left and {robot} have the same {wrong}; each robot needs its own"
    assert (said in done.stdout) == bool(wrong), done.stdout + done.stderr
    assert [f"{name}, host gpu: " in done.stdout for name in ("left", robot)] == [True] * 2


WRONG: dict[str, tuple[tuple[str, ...], Any, str]] = {
    "a HAL's option": (("hal", "options", "camers"), [], "camers: unknown key"),
    "a runner's option": (("runner", "options", "skils"), [], "skils: unknown key"),
    "an assembler's option": (("state_assembler", "options"), {"age": 1}, "age: unknown key"),
    "a camera that no skill's picture fits": (
        ("runner", "options", "skills"), ["pi05-robocasa365-human300-nf4"],
        "needs camera 'robot0_agentview_left' (valid: none); options.cameras of hal",
    ),
    "a port": (("hal", "listen"), "tcp/127.0.0.1:7599", "hal.listen: leave it out: on one host"),
}  # fmt: skip


@pytest.mark.processes
@pytest.mark.parametrize("what", WRONG)
def test_on_one_host_what_a_service_would_refuse_is_said_before_it_starts(
    what: str, tmp_path: Path
) -> None:
    (service, *inner, last), value, said = WRONG[what]
    spec = yaml.safe_load((repo_root() / "compose/panda_mobile_sim.yaml").read_text("utf-8"))
    place = spec["services"][service]
    for one in inner:
        place = place[one]
    place[last] = value
    file = tmp_path / "wrong.yaml"
    file.write_text(yaml.safe_dump(spec), encoding="utf-8")
    done = fairlead_here("deploy", "check", str(file), state=tmp_path)
    assert said in done.stdout + done.stderr
    assert "wrong.yaml" in done.stdout + done.stderr or "camera" in what


@pytest.mark.processes
def test_a_host_that_cannot_be_asked_is_a_problem_with_what_to_do_by_hand(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(yaml.safe_dump(content(access="open")), encoding="utf-8")
    reach = "sh -c 'echo no route to {address} >&2; exit 255'"
    done = fairlead_here("deploy", "check", str(file), "--reach", reach, state=tmp_path)
    assert done.returncode == 1
    assert (
        "PROBLEM host gpu: cannot be asked: no route to 192.0.2.1; by hand, there: " in done.stdout
    )
    assert f"fairlead deploy check {file} --host gpu\n" in done.stdout
    assert "host robot: ready to start; router, hal, safety, state_assembler" in done.stdout
    wrong = fairlead_here("deploy", "check", str(file), "--reach", "ssh {adress}", state=tmp_path)
    assert wrong.returncode == 1
    assert wrong.stderr.endswith(
        "ERROR --reach: expected words and {address}, got 'ssh {adress}'\n"
    )
