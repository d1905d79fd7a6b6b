"""Where the output goes: a full disk, a reader that leaves, a folder that cannot be written."""

from __future__ import annotations

import io
import json
import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import wait_for
from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead.paths import repo_root
from fairlead_tools.cli import console
from fairlead_tools.cli.console import ProgressLine, echo, print_table
from fairlead_tools.cli.main import main
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.cli.background_up import SOURCE
from tests.cli.command import fairlead_command, fairlead_environment
from tests.cli.command import fairlead_here as fairlead


@pytest.mark.processes
@pytest.mark.parametrize("command", ["skill ls", "robot show panda_mobile --json"])
def test_a_full_disk_is_one_line_and_exit_code_1(command: str, tmp_path: Path) -> None:
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        done = subprocess.run(
            fairlead_command(*command.split()),
            env=fairlead_environment(tmp_path),
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=120,
            check=False,
        )
    said = f"ERROR fairlead {command.split()[0]}: No space left on device\n"
    assert (done.returncode, done.stderr) == (1, said)


@pytest.mark.parametrize("options", ["", " --json"])
@pytest.mark.processes
def test_a_system_that_starts_no_more_threads_is_one_line(options: str, tmp_path: Path) -> None:
    narrow = f"ulimit -s {1 << 26}; ulimit -v {1 << 25}; exec "  # a stack does not fit into memory
    command = shlex.join(fairlead_command("topic", "echo", "state/joints", "-d", "panda_mujoco"))
    done = subprocess.run(
        ["/bin/sh", "-c", narrow + command + options], env=fairlead_environment(tmp_path),
        capture_output=True, text=True, timeout=60.0, check=False,
    )  # fmt: skip
    said = "fairlead topic: the system starts no more threads; its limits: ulimit -a"
    assert done.returncode == 1
    assert done.stderr == ("" if options else f"ERROR {said}\n")
    if options:
        assert json.loads(done.stdout)["error"]["message"] == said


def test_an_error_that_finds_no_room_as_a_document_is_said_as_a_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["fairlead", "robot", "show", "nobody", "--json"])
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        monkeypatch.setattr("sys.stdout", full)
        with pytest.raises(SystemExit, match="1"):
            main()
        assert "ERROR robot 'nobody': no file " in capsys.readouterr().err


@pytest.mark.processes
@pytest.mark.timeout(180)
def test_up_on_a_full_disk_loses_what_it_prints_and_nothing_else(tmp_path: Path) -> None:
    options = ScratchOptions(f"full{os.getpid()}", hal=LIGHT_HAL)
    scratch = make_scratch(SOURCE, tmp_path / "robot", options)
    command = fairlead_command("up", str(scratch.file), "--state-dir", str(scratch.state_dir))
    log = scratch.state_dir / "logs" / "up.log"
    with (
        Path("/dev/full").open("w", encoding="utf-8") as full,
        subprocess.Popen(
            command,
            env=fairlead_environment(tmp_path),
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        ) as up,
    ):
        try:
            wait_for(
                lambda: up.poll() is not None or (log.is_file() and " is up" in log.read_text()),
                "all are ready",
                120.0,
            )
            assert up.poll() is None
        finally:
            up.send_signal(signal.SIGINT)
            _, errors = up.communicate(timeout=30.0)
    assert (up.returncode, errors) == (0, "")
    assert "no process is left" in log.read_text(encoding="utf-8")


@pytest.mark.processes
def test_a_reader_that_leaves_is_no_error_text(tmp_path: Path) -> None:
    with subprocess.Popen(
        fairlead_command("skill", "ls"),
        env=fairlead_environment(tmp_path),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as listing:
        assert listing.stdout is not None and listing.stderr is not None
        listing.stdout.close()
        assert listing.stderr.read() == ""


@pytest.mark.parametrize("out", ["/proc/nowhere", "{}/file/below"])
def test_a_demo_that_cannot_write_says_so_before_anything_starts(out: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    folder = out.format(tmp_path)
    done = fairlead("demo", "--out", folder, state=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith(f"ERROR demo: cannot write to {folder}: ")
    assert "starting" not in done.stderr


def test_a_demo_of_another_robots_skill_says_why_before_anything_starts(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = fairlead("demo", "--skill", "panda-joint-reach", "--out", str(out), state=tmp_path)
    assert done.returncode == 1 and not out.exists()
    assert done.stderr.startswith(
        "ERROR skill panda-joint-reach cannot run on robot panda_mobile:\n"
        "  embodiments: made for panda, not panda_mobile\n"
    )
    assert done.stderr.endswith("  try: fairlead skill ls --robot panda_mobile\n")


def test_skill_ls_says_one_reason_a_skill_and_where_the_others_are(tmp_path: Path) -> None:
    lines = fairlead("skill", "ls", state=tmp_path).stdout.splitlines()
    (reach,) = (line for line in lines if line.startswith("panda-joint-reach"))
    assert reach.split("  ")[-2:] == [
        "embodiments: made for panda, not panda_mobile",
        "(all 2: fairlead skill check panda-joint-reach --robot panda_mobile)",
    ]
    rows = {row["skill"]: row for row in json.loads(
        fairlead("skill", "ls", "--json", state=tmp_path).stdout)}  # fmt: skip
    assert len(rows["panda-joint-reach"]["reasons"]) == 2


def test_skill_ls_is_of_the_robot_that_runs_here(tmp_path: Path) -> None:
    here = ServiceEntry(process_id(os.getpid()), ready=True, restarts=0, by_hand=True)
    for file, robot in (
        (repo_root() / "compose" / "panda_mujoco.yaml", "panda"),
        (tmp_path / "gone.yaml", "panda_mobile"),
    ):
        Registry(tmp_path).write(Running("robot", str(file), str(tmp_path), None, {"hal": here}))
        heading = fairlead("skill", "ls", state=tmp_path).stdout.splitlines()[0]
        assert re.search(r"ON (\w+)", heading)[1] == robot, heading  # type: ignore[index]


def test_a_table_keeps_its_columns_apart(capsys: pytest.CaptureFixture[str]) -> None:
    print_table(("A", "LONGER"), [("wide cell", 1), ("", "x")])
    assert capsys.readouterr().out == "A          LONGER\nwide cell  1\n           x\n"


ESCAPES = "\x1b]0;owned\x07\x9b2J\r\u202e"


def assert_harmless(said: str) -> None:
    """No control character but the ends of lines, whoever wrote the text."""
    assert "\\x1b]0;owned\\x07\\xc2\\x9b2J\\x0d\\xe2\\x80\\xae" in said
    assert all(line.isprintable() for line in said.split("\n")), said


def test_what_a_file_says_cannot_steer_the_terminal(tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(f"{json.dumps(ESCAPES)}: 1\n", encoding="utf-8")
    assert_harmless(fairlead("up", str(file), state=tmp_path).stderr)


@pytest.mark.processes
def test_what_a_service_printed_cannot_steer_the_terminal(tmp_path: Path) -> None:
    logs = tmp_path / "state" / "logs"
    logs.mkdir(parents=True)
    (logs / "hal.log").write_text(f"1\ttab {ESCAPES}\n2\n", encoding="utf-8")
    told = fairlead("logs", "--state-dir", str(logs.parent), state=tmp_path).stdout
    assert_harmless(told)
    assert told.startswith("[hal] 1 ") and told.endswith("\n[hal] 2\n")


def test_progress_and_tables_cannot_steer_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with ProgressLine() as line:
        line.show(f"loading {ESCAPES}")
        line.say(ESCAPES)
    print_table(("A",), [(ESCAPES,)])
    said = capsys.readouterr()
    assert_harmless(said.err)
    assert_harmless(said.out)


def test_progress_in_a_file_ends_with_its_newest_line_and_repeats_none(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for lines in (("one",), ("one", "two", "three")):
        with ProgressLine() as line:
            for text in lines:
                line.show(text)
        assert capsys.readouterr().err.split() == list(dict.fromkeys((lines[0], lines[-1])))


def test_a_terminal_that_cannot_move_its_cursor_gets_lines(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "dumb")
    with ProgressLine() as line:
        line.show("one")
    assert capsys.readouterr().err == "one\n"


def test_what_takes_long_counts_its_seconds(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(console, "LINE_EVERY_S", 0.0)
    monkeypatch.setattr(console, "WORD_EVERY_S", 0.01)
    said: list[str] = []

    def printed(line: str) -> bool:
        said.extend(capsys.readouterr().err.splitlines())
        return line in said

    with ProgressLine() as line, line.counting() as say:
        say("one")
        wait_for(lambda: printed("one (0 s)"), "the seconds of the first", 10.0)
        say("two")
        wait_for(lambda: printed("two (0 s)"), "the seconds of the next", 10.0)
    assert said[0] == "one"


def test_what_a_terminal_has_no_letter_for_is_spelled_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """A policy prints what it likes; a service whose line cannot be shown goes on all the same."""
    shown = io.BytesIO()
    with io.TextIOWrapper(shown, encoding="latin-1") as terminal:
        monkeypatch.setattr(sys, "stdout", terminal)
        monkeypatch.setattr(sys, "argv", ["fairlead", "--version"])
        with pytest.raises(SystemExit):
            main()
        echo("[runner] \u2713")
        terminal.flush()
        assert b"[runner] \\u2713\n" in shown.getvalue()


def test_a_file_that_cannot_be_written_is_a_document_where_one_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(as_json: bool) -> None:
        Path("/dev/null/below").write_text("", encoding="utf-8")

    monkeypatch.setattr("fairlead_tools.cli.main._run", run)
    monkeypatch.setattr(sys, "argv", ["fairlead", "eval", "--json"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 1
    said = {"kind": "OSError", "message": "/dev/null/below: Not a directory", "fix": ""}
    assert json.loads(capsys.readouterr().out) == {"error": said}
