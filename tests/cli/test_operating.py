"""Stopping and arming from outside, with real gates and nothing else running."""

from __future__ import annotations

import asyncio
import errno
import json
import os
import pty
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead.deploy.service_manager import NOTIFY_VARIABLE
from fairlead.errors import TransportError
from fairlead.operate.asker import OPERATOR_VARIABLE
from fairlead.paths import repo_root
from fairlead_tools.cli import arming
from fairlead_tools.supervisor.child import is_ready_line
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.cli.command import fairlead, fairlead_command, fairlead_environment, fairlead_here
from tests.shape.own_robot import NAME, own_robot, with_hardware

SOURCE = repo_root() / "compose" / "panda_mobile_sim.yaml"


class Gate:
    """One gate, started by its own command."""

    def __init__(self, name: str, folder: Path, **changes: Any) -> None:
        scratch = make_scratch(SOURCE, folder / name, ScratchOptions(f"{name}{os.getpid()}"))
        self.file, self.id, self.state = scratch.file, scratch.deployment.id, folder / "registry"
        content = yaml.safe_load(self.file.read_text(encoding="utf-8")) | changes
        self.file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        self.process = subprocess.Popen(
            fairlead_command("service", str(self.file), "safety"),
            env=fairlead_environment(self.state),
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if is_ready_line(line.rstrip()):
                break

    def end(self) -> None:
        self.process.kill()
        assert self.process.stdout is not None
        self.process.stdout.close()
        self.process.wait(timeout=30.0)


@pytest.fixture
def gates(tmp_path: Path) -> Iterator[list[Gate]]:
    started: list[Gate] = []
    yield started
    for gate in started:
        gate.end()


@pytest.mark.processes
def test_stop_stops_every_robot_that_runs_here(gates: list[Gate], tmp_path: Path) -> None:
    gates += [Gate("one", tmp_path), Gate("other", tmp_path)]
    state = gates[0].state
    stopped = fairlead("stop", "--reason", "test", state=state)
    assert stopped.returncode == 0, stopped.stderr
    lines = sorted(stopped.stdout.splitlines())
    for gate, line in zip(gates, lines, strict=True):
        assert line.startswith(f"stopped {gate.id}; when it is safe: fairlead reset ")
        reset = fairlead_here(*line.partition(": fairlead ")[2].split(), state=state)
        assert reset.returncode == 0, reset.stderr

    gates[0].end()
    again = fairlead_here("stop", state=state)  # the dead one is not listed any more
    assert again.returncode == 0 and gates[1].id in again.stdout


@pytest.mark.processes
def test_a_stop_that_one_robot_does_not_take_is_an_error_and_stops_the_others(
    gates: list[Gate], tmp_path: Path
) -> None:
    gates += [Gate("one", tmp_path), Gate("other", tmp_path)]
    gates[0].process.send_signal(signal.SIGSTOP)
    stopped = fairlead_here("stop", state=gates[0].state)
    assert stopped.returncode == 1
    assert stopped.stdout.startswith(f"stopped {gates[1].id};")
    assert f"ERROR {gates[0].file}: NOT STOPPED: " in stopped.stderr


def test_a_stop_is_said_before_its_session_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A session with a service that hangs takes 10 s to end, and its end may fail."""
    said: list[str] = []

    class Stops:
        async def __aenter__(self) -> Stops:
            return self

        async def stop(self, reason: str) -> int:
            return len(reason)

        async def __aexit__(self, *_: object) -> None:
            said.append(capsys.readouterr().out)
            raise TransportError("the session does not end")

    monkeypatch.setenv("FAIRLEAD_STATE", str(tmp_path))
    monkeypatch.setattr(arming, "connect", lambda *_, **__: Stops())
    assert asyncio.run(arming._stop(SOURCE, SOURCE, "hand in the cell"))
    assert said == ["stopped panda_mobile; when it is safe: fairlead reset 0000000000000010\n"]
    assert capsys.readouterr() == ("", "")


@pytest.mark.processes
@pytest.mark.parametrize("reason", ["T\udcfcr offen", "a" * 70_000])
def test_no_name_and_no_reason_keep_a_stop_from_being_sent_and_reset(
    reason: str, gates: list[Gate], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(OPERATOR_VARIABLE, "Ada Lovelace")
    gates.append(Gate("one", tmp_path))
    state = gates[0].state
    stopped = fairlead("stop", "--reason", reason, state=state)
    assert stopped.returncode == 0, stopped.stderr
    assert stopped.stderr.startswith(f"WARNING {OPERATOR_VARIABLE}: expected ")
    assert "Traceback" not in stopped.stderr
    monkeypatch.delenv(OPERATOR_VARIABLE)
    reset = fairlead_here(*stopped.stdout.partition(": fairlead ")[2].split(), state=state)
    assert reset.returncode == 0, reset.stderr


@pytest.mark.processes
def test_a_robot_is_stopped_also_when_its_file_cannot_be_read_any_more(
    gates: list[Gate], tmp_path: Path
) -> None:
    gates.append(Gate("one", tmp_path))
    gates[0].file.write_text("robot: [", encoding="utf-8")
    stopped = fairlead_here("stop", state=gates[0].state)
    assert stopped.returncode == 0, stopped.stderr
    assert stopped.stdout.startswith(f"stopped {gates[0].id};")


@pytest.mark.processes
@pytest.mark.parametrize("edit", ["namespace", "id"])
def test_a_robot_is_stopped_as_it_was_started_whatever_its_file_says_now(
    edit: str, gates: list[Gate], tmp_path: Path
) -> None:
    gates.append(Gate("one", tmp_path))
    content = yaml.safe_load(gates[0].file.read_text(encoding="utf-8"))
    content[edit] = "renamed"
    gates[0].file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    stopped = fairlead_here("stop", state=gates[0].state)
    assert stopped.returncode == 0, stopped.stderr
    assert stopped.stdout.startswith(f"stopped {gates[0].id};")


def test_each_robot_that_was_started_of_a_file_is_stopped_as_it_was_then(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_STATE", str(tmp_path / "state"))
    file, registry = tmp_path / "cell.yaml", Registry()
    for name in ("left", "right"):
        file.write_text(name, encoding="utf-8")
        own = {"safety": ServiceEntry(process_id(os.getpid()), True, 0, by_hand=True)}
        entry = Running(name, str(file), "/state", None, own)
        registry.write_by_hand("safety", entry, is_gate=True)
    file.write_text("other", encoding="utf-8")
    registry.write_by_hand("runner", Running("left", str(file), "/state", None, {}), is_gate=False)
    assert [kept.read_text() for kept in registry.kept_files(file)] == ["left", "right"]
    registry.remove("left")  # an `up` beside it that ends
    assert [kept.read_text() for kept in registry.kept_files(file)] == ["left", "right"]
    (tmp_path / "state" / "running" / "left.yaml").unlink()
    assert [kept.read_text() for kept in registry.kept_files(file)] == ["other", "right"]
    (tmp_path / "state" / "running" / "right.yaml").write_text("other")  # two hosts of one robot
    assert len(registry.kept_files(file)) == 1


@pytest.mark.processes
def test_what_a_service_manager_starts_again_is_its_own_to_end(
    gates: list[Gate], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = os.umask(0o022)
    monkeypatch.setenv(NOTIFY_VARIABLE, str(tmp_path / "nobody"))
    try:
        gates.append(Gate("one", tmp_path))
    finally:
        os.umask(before)
    ended = fairlead_here("down", state=gates[0].state)
    assert ended.returncode == 1
    assert "systemd would start safety again" in ended.stderr
    assert f"sudo systemctl stop fairlead-{gates[0].id}.target" in ended.stderr
    assert gates[0].process.poll() is None
    for path in gates[0].state.rglob("*"):
        assert path.stat().st_mode & 0o077 == 0 or path.is_symlink(), path


@pytest.mark.processes
def test_a_robot_that_is_real_is_not_armed_where_nobody_can_be_asked(
    gates: list[Gate], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_hardware(own_robot(tmp_path / "robots", monkeypatch), {})
    compiled = fairlead_here("robot", "compile", NAME, state=tmp_path)
    assert compiled.returncode == 0, compiled.stderr
    gates.append(Gate("real", tmp_path, robot=NAME, profile="hardware", pacing="realtime"))
    state = gates[0].state
    unasked = fairlead("arm", state=state)
    assert unasked.returncode == 1
    assert unasked.stderr == (
        "ERROR arm refused: the robot is real and will move, and there is no terminal to ask at\n"
        "  try: add --yes, if people keep clear of it\n"
    )
    sure = fairlead_here("arm", "--yes", state=state)  # the gate has its own reasons: no HAL
    assert "safety refused: " in sure.stderr

    asked, answered = ask_on_a_terminal(fairlead_command("arm"), state, "n\n")
    assert "The robot is real and will move. Arm it? [y/N]: " in asked
    assert answered == 1


def ask_on_a_terminal(command: list[str], state: Path, answer: str) -> tuple[str, int]:
    """What a command shows on a terminal of 80 columns, and how it ends."""
    near, far = pty.openpty()
    os.set_inheritable(far, True)
    environment = fairlead_environment(state) | {"TERM": "xterm"}
    with subprocess.Popen(command, env=environment, stdin=far, stdout=far, stderr=far) as process:
        os.close(far)
        os.write(near, answer.encode())
        shown = read_all(near)
        status = process.wait(timeout=60.0)
    return shown, status


def read_all(terminal: int) -> str:
    shown = b""
    try:
        while piece := os.read(terminal, 4096):
            shown += piece
    except OSError as error:
        if error.errno != errno.EIO:  # how a terminal says that nobody writes any more
            raise
    os.close(terminal)
    return shown.decode()


@pytest.mark.processes
def test_a_progress_line_is_never_wider_than_the_terminal(tmp_path: Path) -> None:
    program = (
        "import fcntl, struct, sys, termios\n"
        "fcntl.ioctl(2, termios.TIOCSWINSZ, struct.pack('HHHH', 24, 80, 0, 0))\n"
        "from fairlead_tools.cli.console import ProgressLine\n"
        "with ProgressLine() as line:\n"
        "    line.show('x' * 79)\n"
        "    line.show('y' * 80)\n"
        "    line.show('z' * 300)\n"
    )
    shown, status = ask_on_a_terminal([sys.executable, "-c", program], tmp_path, "")
    assert status == 0, shown
    rows = re.split(r"\r\x1b\[2K", shown)[1:]
    assert rows[:3] == ["x" * 79, "y" * 78 + "…", "z" * 78 + "…"]
    assert rows[3] == "z" * 300 + "\r\n", "in the end it is left whole"


@pytest.mark.parametrize("command", ["status --json", "skill show orcale --json", "why --json"])
def test_with_json_an_error_is_json_too(command: str, tmp_path: Path) -> None:
    done = fairlead_here(*command.split(), state=tmp_path)
    assert (done.returncode, done.stderr) == (1, "")
    error = json.loads(done.stdout)["error"]
    assert set(error) == {"kind", "message", "fix"} and error["message"]


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("status --foo --json", "No such option: --foo"),
        ("run --json", "Missing argument 'SKILL_OR_CHAIN'"),
        ("why soon --json", "expected `last`, a tick such as 120 or a check such as G020, got 'so"),
        ("status -d nowhere --json", "nowhere"),
    ],
)
def test_with_json_a_wrong_command_line_is_json_too(
    command: str, message: str, tmp_path: Path
) -> None:
    done = fairlead_here(*command.split(), state=tmp_path)
    assert (done.returncode, done.stderr) == (2, "")
    assert message in json.loads(done.stdout)["error"]["message"]
