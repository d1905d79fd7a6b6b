"""``up`` while it starts: what looks on sees it, and a gate that dies at once is started again."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import wait_for
from fairlead.deploy.process_table import ProcessId
from fairlead.deploy.registry import Registry
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from fairlead_tools.supervisor.this_host import free_ports
from tests.cli.command import fairlead, fairlead_command, fairlead_environment, fairlead_here
from tests.cli.process_list import pids_that_mention

pytestmark = [pytest.mark.processes, pytest.mark.timeout(200)]

COMPOSE = repo_root() / "compose"


class Up:
    """``fairlead up`` in the background, and what it prints."""

    def __init__(self, file: Path, state: Path, *options: str) -> None:
        self.state = state
        self.lines: list[str] = []
        self.process = subprocess.Popen(
            fairlead_command("up", str(file), *options),
            env=fairlead_environment(state),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as stream:
            self.lines.extend(line.rstrip() for line in stream)

    def wait_line(self, text: str) -> str:
        wait_for(lambda: any(text in line for line in self.lines), f"up prints {text!r}", 120.0)
        return next(line for line in self.lines if text in line)

    def services(self) -> dict[str, Any]:
        entries = json.loads(fairlead_here("ps", "--json", state=self.state).stdout)
        return dict(entries[0]["services"]) if entries else {}


@pytest.fixture
def start_up(tmp_path: Path) -> Iterator[Callable[..., Up]]:
    started: list[Up] = []

    def start(file: Path, *options: str) -> Up:
        started.append(Up(file, tmp_path / "registry", *options))
        return started[-1]

    yield start
    for up in started:
        up.process.kill()
        up.process.wait(timeout=30.0)


def test_a_deployment_with_two_runners_starts(start_up: Callable[..., Up], tmp_path: Path) -> None:
    options = ScratchOptions(hal=LIGHT_HAL)
    source = COMPOSE / "panda_mobile_navigation.yaml"
    up = start_up(make_scratch(source, tmp_path / "state", options).file)
    up.wait_line("ready")
    assert {"navigation", "manipulation"} <= set(up.services())


@pytest.fixture
def two_hosts(tmp_path: Path) -> Path:
    """A deployment whose other host, with the router, is not there."""
    content = yaml.safe_load((COMPOSE / "panda_mobile_two_hosts.yaml").read_text(encoding="utf-8"))
    content |= {"hosts": {"robot": "127.0.0.2", "gpu": "127.0.0.1"}}
    content |= {"id": f"w{os.getpid()}", "access": "open"}
    content["router"]["port"] = free_ports(1)[0]
    file = tmp_path / "two_hosts.yaml"
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return file


def test_an_up_that_waits_for_its_router_is_listed_and_ended(
    two_hosts: Path, start_up: Callable[..., Up]
) -> None:
    up = start_up(two_hosts, "--host", "gpu")
    up.wait_line("[up] waiting: router tcp/127.0.0.2:")
    assert up.services()["runner"]["state"] == "waiting"
    down = fairlead_here("down", state=up.state)
    assert down.returncode == 0, down.stderr
    assert down.stdout == f"stopped w{os.getpid()}:gpu\n"
    assert up.process.wait(timeout=30.0) == 0


def test_a_gate_that_dies_while_the_robot_comes_up_is_started_again(
    start_up: Callable[..., Up], tmp_path: Path
) -> None:
    options = ScratchOptions(f"rough{os.getpid()}", hal=LIGHT_HAL)
    scratch = make_scratch(COMPOSE / "panda_mobile_sim.yaml", tmp_path / "rough", options)
    up = start_up(scratch.file)
    assembler = running(up, "state_assembler")
    assembler.send(signal.SIGSTOP)  # so that the start lasts as long as the test wants
    wait_for(lambda: starting(up) == "state_assembler", "the others are ready", 120.0)

    up.wait_line(" INFO safety: ready")
    running(up, "safety").send(signal.SIGKILL)
    up.wait_line("[up] safety was killed by signal 9; starting it again in 0.5 s")
    assembler.send(signal.SIGCONT)
    up.wait_line(" is up; state and logs: ")
    assert up.process.poll() is None
    assert up.services()["safety"]["restarts"] == 1
    assert fairlead_here("down", state=up.state).returncode == 0


def test_a_deployment_that_is_ended_while_it_starts_leaves_no_process(
    start_up: Callable[..., Up], tmp_path: Path
) -> None:
    options = ScratchOptions(f"early{os.getpid()}", hal=LIGHT_HAL)
    up = start_up(make_scratch(COMPOSE / "panda_mobile_sim.yaml", tmp_path / "early", options).file)
    running(up, "state_assembler").send(signal.SIGSTOP)  # not ready before it is ended
    down = fairlead_here("down", state=up.state)
    assert (down.returncode, down.stdout) == (0, f"stopped early{os.getpid()}\n"), down.stderr
    assert up.process.wait(timeout=30.0) == 0
    assert [pid for pid in pids_that_mention(up.state) if pid != up.process.pid] == []
    assert up.services() == {}


def test_a_detached_up_returns_when_all_is_ready_and_runs_on_until_down(tmp_path: Path) -> None:
    state, name = tmp_path / "registry", f"detached{os.getpid()}"
    scratch = make_scratch(
        COMPOSE / "panda_mobile_sim.yaml", tmp_path / name,
        ScratchOptions(name, hal=LIGHT_HAL),
    )  # fmt: skip
    words = ("up", str(scratch.file), "--state-dir", str(tmp_path / name), "--detach")
    try:
        done = fairlead(*words, state=state)
        assert done.returncode == 0, done.stderr
        assert f"[up] {name} is up; state and logs: " in done.stdout
        assert [line for line in done.stdout.splitlines() if "ignored" in line] == []
        assert f"stop it: fairlead down {name}\n" in done.stdout
        assert f"fairlead logs -f -d {name}\n" in done.stdout
        again = fairlead(*words, state=state)
        assert (again.returncode, again.stdout) == (1, "")
        assert "is already running" in again.stderr
        (entry,) = json.loads(fairlead_here("ps", "--json", state=state).stdout)
        assert {one["state"] for one in entry["services"].values()} == {"ready"}
        os.kill(entry["services"]["state_assembler"]["process"]["pid"], signal.SIGKILL)
        log = tmp_path / name / "logs" / "up.log"
        said = "Z INFO up: state_assembler is ready again"
        wait_for(lambda: said in log.read_text(encoding="utf-8"), "its own lines are kept", 60.0)
        assert fairlead_here("stop", state=state).returncode == 0
    finally:
        ended = fairlead_here("down", state=state)
    assert ended.stdout == (
        f"stopped {name}\n"
        "its last gate (safety) did not end disarmed: it will start latched, until fairlead reset\n"
    ), ended.stderr


def test_a_detached_up_does_not_wait_for_what_somebody_else_starts(tmp_path: Path) -> None:
    state, name = tmp_path / "registry", f"without{os.getpid()}"
    scratch = make_scratch(
        COMPOSE / "panda_mobile_sim.yaml", tmp_path / name, ScratchOptions(name, hal=LIGHT_HAL)
    )
    words = ("up", str(scratch.file), "--state-dir", str(tmp_path / name), "--without", "safety")
    try:
        done = fairlead(*words, "--detach", state=state)
        assert done.returncode == 0, done.stderr
        assert "[up] not seen yet: safety; start with: fairlead service FILE safety" in done.stdout
        assert f"stop it: fairlead down {name}\n" in done.stdout
        (entry,) = json.loads(fairlead_here("ps", "--json", state=state).stdout)
        assert [one["state"] for one in entry["services"].values()] == ["ready"] * 3
    finally:
        ended = fairlead_here("down", state=state)
    assert ended.stdout == f"stopped {name}\n", ended.stderr


HAL_THAT_FAILS = """
import sys
from dataclasses import replace
from fairlead.hal.process import Equipment, run_hal
from fairlead.service import run_service
from fairlead_hal_kinematic.kinematic_backend import KinematicBackend

class Fails(KinematicBackend):
    def read(self):
        return replace(super().read(), efforts=None)

async def body(context):
    await run_hal(context, lambda robot: Equipment(Fails(robot, "sim")), what="fails")

sys.exit(run_service("fails", body))
"""


def test_a_detached_up_returns_when_the_hal_has_a_fault_before_any_state(tmp_path: Path) -> None:
    state, name = tmp_path / "registry", f"faulty{os.getpid()}"
    script = tmp_path / "hal.py"
    script.write_text(HAL_THAT_FAILS, encoding="utf-8")
    scratch = make_scratch(
        COMPOSE / "panda_mobile_sim.yaml", tmp_path / name,
        ScratchOptions(name, hal={"command": [sys.executable, str(script)]}),
    )  # fmt: skip
    words = ("up", str(scratch.file), "--state-dir", str(tmp_path / name), "--detach")
    try:
        done = fairlead(*words, state=state)
        assert done.returncode == 0, done.stderr
        (said,) = (line for line in done.stdout.splitlines() if "fault of hal: " in line)
        assert "expected efforts as an array of " in said and said.endswith("fairlead restart hal")
        assert f"stop it: fairlead down {name}\n" in done.stdout
    finally:
        ended = fairlead_here("down", state=state)
    assert ended.stdout.startswith(f"stopped {name}\n"), ended.stderr


def test_an_interrupted_detached_start_leaves_nothing(
    two_hosts: Path, start_up: Callable[..., Up]
) -> None:
    up = start_up(two_hosts, "--host", "gpu", "--detach")
    up.wait_line("[up] waiting: router tcp/127.0.0.2:")
    up.process.send_signal(signal.SIGINT)
    assert up.process.wait(timeout=30.0) == 130
    assert up.services() == {}


def starting(up: Up) -> str:
    """Who is not ready yet, as ``status`` says it."""
    status = fairlead_here("status", state=up.state)
    assert status.returncode == 1, status.stdout
    [said] = [line for line in status.stdout.splitlines() if line.startswith("starting ")]
    return said.removeprefix("starting ").removesuffix("; ask again in a moment")


def running(up: Up, service: str) -> ProcessId:
    """A service's process, once it has one."""
    registry = Registry(up.state)

    def found() -> ProcessId | None:
        services = [e.services for e in registry.entries() if service in e.services]
        return services[0][service].running if services else None

    wait_for(lambda: found() is not None, f"{service} is started", 60.0)
    process = found()
    assert process is not None
    return process
