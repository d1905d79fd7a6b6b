"""A user's mistake: one clear text on standard error, the right exit code, no traceback."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running
from fairlead.paths import repo_root
from tests.cli.command import fairlead_command, fairlead_environment
from tests.cli.command import fairlead_here as fairlead

COMPOSE = repo_root() / "compose"


@pytest.fixture
def broken_file(tmp_path: Path) -> Path:
    path = tmp_path / "broken.yaml"
    path.write_text("robot: panda_mobile\nid: A\nservices: {}\nextra: 1\n", encoding="utf-8")
    return path


def check(done: subprocess.CompletedProcess[str], code: int, *texts: str) -> None:
    assert done.returncode == code, done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    for text in texts:
        assert text in done.stderr, done.stderr


WRONG_COMMAND_LINES = {
    "no such command": (["fly"], "No such command 'fly'"),
    "no such option": (["ps", "--all"], "No such option"),
    "a file that is not there": (["up", "nowhere.yaml"], "nowhere.yaml"),
    "a deployment that is not there": (["status", "-d", "nowhere"], "panda_mujoco"),
    "an argument left out": (["run"], "Missing argument 'SKILL_OR_CHAIN'"),
    "an id that is no number": (["reset", "xyz"], "expected 1 to 16 hex digits"),
    "an id of zero": (["reset", "0"], "expected 1 to 16 hex digits"),
    "an id that is too long": (["reset", "1" * 17], "expected 1 to 16 hex digits"),
    "a negative seed": (["parity", "--seed", "-1"], "greater than or equal to 0"),
    "a seed beyond 64 bits": (["run", "x", "--seed", str(2**64)], f"equal to {2**64 - 1}"),
    "a time to listen beyond a day": (["topic", "list", "--seconds", "1e99"], "equal to 86400"),
    "words that are no UTF-8": (
        ["run", "x", "--prompt", "\udcff"],
        "words in UTF-8, got '\\\\udcff'",
    ),
    "no number": (["run", "x", "--stall-timeout", "nan"], "equal to 86400"),
    "a deadline beyond 64 bits": (
        ["run", "x", "--deadline-ticks", str(2**64)],
        f"equal to {2**64 - 1}",
    ),
}


@pytest.mark.parametrize("name", WRONG_COMMAND_LINES)
def test_a_wrong_command_line_exits_with_2(name: str, tmp_path: Path) -> None:
    arguments, text = WRONG_COMMAND_LINES[name]
    check(fairlead(*arguments, state=tmp_path), 2, text)


NOTHING_RUNS = ("arm", "disarm", "stop", "status", "down", "logs", "reset 1f")


@pytest.mark.parametrize("command", NOTHING_RUNS)
def test_with_nothing_running_the_way_to_start_is_named(command: str, tmp_path: Path) -> None:
    done = fairlead(*command.split(), state=tmp_path)
    check(done, 1, "no deployment runs on this machine", "fairlead up")


def test_asking_a_robot_that_does_not_answer_names_who_is_missing(tmp_path: Path) -> None:
    file = tmp_path / "elsewhere.yaml"
    file.write_bytes((COMPOSE / "panda_mobile_sim.yaml").read_bytes())
    done = fairlead("status", "--deployment", str(file), state=tmp_path)
    check(
        done,
        1,
        "ERROR robot panda_mobile: hal, runner, safety, state_assembler not seen within 3 s",
        "fairlead ps",
    )


def test_a_broken_deployment_file_is_named_with_every_problem(
    broken_file: Path, tmp_path: Path
) -> None:
    done = fairlead("up", str(broken_file), state=tmp_path)
    check(done, 1, f"ERROR {broken_file}: 2 problem(s)", ": id: ", ": extra: ")


COMPOSED = (COMPOSE / "panda_mobile_sim.yaml").read_text(encoding="utf-8")
OPENED = "access: open\n" + COMPOSED.replace(
    "    run: hal_sim\n", "    run: hal_sim\n    listen: tcp/127.0.0.1:7501\n"
).replace("{run: safety}", "{run: safety, listen: tcp/127.0.0.1:7502}")
BROKEN_FILES = {
    "nothing in it": ("", "expected `key: value` lines, got nothing"),
    "a list": ("- 1\n", "expected `key: value` lines, got list"),
    "a port that cannot be": (OPENED.replace(":7502", ":99999"), "services.safety.listen: "),
    "two services on a port": (OPENED.replace(":7502", ":7501"), "safety.listen: hal listens on"),
    "a key given twice": (COMPOSED + "id: twice\n", "key 'id' is given twice, first in line "),
}


@pytest.mark.parametrize("name", BROKEN_FILES)
def test_nothing_is_started_from_a_file_with(name: str, tmp_path: Path) -> None:
    content, text = BROKEN_FILES[name]
    file = tmp_path / "broken.yaml"
    file.write_text(content, encoding="utf-8")
    done = fairlead("up", str(file), state=tmp_path)
    check(done, 1, f"ERROR {file}:", text)
    assert done.stdout == ""


def test_a_file_that_is_no_text_is_named(tmp_path: Path) -> None:
    file = tmp_path / "picture.yaml"
    file.write_bytes(b"\x89PNG\xff")
    check(fairlead("up", str(file), state=tmp_path), 1, f"ERROR {file}: not a text file in UTF-8")


@pytest.mark.parametrize(
    "command",
    ["run {}", "skill show {}", "skill check {}", "layout verify {}", "parity --skill {}"],
)
def test_a_misspelt_skill_lists_the_skills_there_are(command: str, tmp_path: Path) -> None:
    done = fairlead(*command.format("orcale").split(), state=tmp_path)
    check(done, 1, "skill 'orcale'", "valid: ", "oracle-counter-to-cabinet")


def test_parity_of_a_robot_that_is_not_in_robosuite_says_so_before_anything_starts(
    tmp_path: Path,
) -> None:
    command = "parity --skill panda-joint-reach -d panda_mujoco"
    done = fairlead(*command.split(), "--out", str(tmp_path / "out"), state=tmp_path)
    check(done, 1, "parity: expected a deployment that runs hal_sim (robosuite)", "hal_mujoco")
    assert not (tmp_path / "out").exists()


def test_parity_of_a_skill_that_does_not_tell_the_whole_robot_says_what_it_leaves_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    skills = tmp_path / "skills"
    skills.mkdir()
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(skills))
    monkeypatch.chdir(skills)
    made = fairlead("skill", "new", "my-wave", "--robot", "panda_mobile", state=tmp_path)
    assert made.returncode == 0, made.stderr
    done = fairlead("parity", "--skill", "my-wave", state=tmp_path)
    check(
        done, 1, "skill my-wave tells arm of panda_mobile and leaves out gripper, base, composite"
    )


@pytest.mark.parametrize("command", ["robot show {}", "robot compile {}", "skill ls --robot {}"])
def test_a_misspelt_robot_lists_the_robots_there_are(command: str, tmp_path: Path) -> None:
    done = fairlead(*command.format("pnda").split(), state=tmp_path)
    check(done, 1, "robot 'pnda'", "valid: ", "panda_mobile")


def test_an_unknown_profile_lists_those_there_are(tmp_path: Path) -> None:
    done = fairlead("robot", "show", "panda_mobile", "--profile", "toy", state=tmp_path)
    check(done, 1, "expected a safety profile, got 'toy' (valid: ", "sim")


def test_logs_say_where_the_lines_are_of_what_up_did_not_start(tmp_path: Path) -> None:
    check(fairlead("logs", "hal", state=tmp_path), 1, "by hand", "--state-dir")
    (tmp_path / "old" / "logs").mkdir(parents=True)
    (tmp_path / "old" / "logs" / "safety.log").write_text("INFO\n", encoding="utf-8")
    done = fairlead("logs", "hal", "--state-dir", str(tmp_path / "old"), state=tmp_path)
    check(done, 1, "logs: expected a service that `fairlead up` ran, got 'hal' (valid: safety)")
    check(done, 1, "by hand")


def test_logs_of_a_folder_that_holds_none_says_so(tmp_path: Path) -> None:
    done = fairlead("logs", "--state-dir", str(tmp_path), state=tmp_path)
    check(done, 1, f"no *.log in {tmp_path / 'logs'}")


@pytest.mark.processes
@pytest.mark.parametrize("order", ["hal,gate", "hal,safety", "hal,hal,safety,runner"])
def test_a_start_order_must_name_each_service_once(order: str, tmp_path: Path) -> None:
    file = COMPOSE / "panda_mobile_sim.yaml"
    done = fairlead("up", str(file), "--order", order, state=tmp_path)
    wanted = "expected each of hal, safety, state_assembler, runner once"
    check(done, 1, f"start order: {wanted}, got {order.replace(',', ', ')}")


@pytest.mark.processes
@pytest.mark.parametrize("command", ["check", "install"])
def test_a_misspelt_option_of_a_policy_is_found_before_the_skill_runs(
    command: str, tmp_path: Path
) -> None:
    shipped = repo_root() / "rskills" / "rldx-robocasa" / "rskill.yaml"
    mine = tmp_path / "rskills" / "mine"
    mine.mkdir(parents=True)
    text = shipped.read_text(encoding="utf-8").replace("id: rldx-robocasa", "id: mine")
    text = text.replace("language_key:", "langage_key:")
    (mine / "rskill.yaml").write_text(text, encoding="utf-8")
    wanted = "mine" if command == "check" else str(mine)
    done = subprocess.run(
        fairlead_command("skill", command, wanted),
        env=fairlead_environment(tmp_path) | {"FAIRLEAD_SKILLS": str(mine.parent)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 1
    said = done.stdout + done.stderr
    assert "policy.options: rldx policy: 2 problem(s):" in said
    assert "langage_key: unknown key, did you mean language_key? (valid: address, " in said


def test_an_advised_command_can_be_typed_where_a_path_has_blanks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "skills"))
    own, other = tmp_path / "own" / "wave", tmp_path / "an other" / "wave"
    for folder in (own, other):
        folder.parent.mkdir()
        monkeypatch.chdir(folder.parent)
        assert fairlead("skill", "new", "wave", "--robot", "so101", state=tmp_path).returncode == 0
    assert fairlead("skill", "install", "--link", str(own), state=tmp_path).returncode == 0
    check(fairlead("run", str(other), state=tmp_path), 1, f"install --link --force '{other}'\n")

    for name in ("a b", "c"):
        own_process = process_id(os.getpid())
        Registry(tmp_path).write(Running(name, f"/{name}.yaml", str(tmp_path), own_process))
    check(fairlead("status", state=tmp_path), 1, "--deployment '/a b.yaml'\n  --deployment /c.yaml")


@pytest.mark.parametrize("command", ["ps", "stop", "robot show so101", "run so101-reach"])
def test_in_a_folder_that_is_gone_commands_work_all_the_same(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    done = fairlead(*command.split(), state=tmp_path / "state")
    said = done.stdout + done.stderr
    assert "no deployment runs on this machine" in said or said.startswith("so101"), said


def test_a_skill_s_own_file_is_no_chain(tmp_path: Path) -> None:
    done = fairlead("run", "./my-wave/rskill.yaml", state=tmp_path)
    check(done, 1, "ERROR run: expected the skill's folder, without rskill.yaml, got './my-wave/r")
