"""Another user listens where a service is away: nobody's proof helps him to a link of any use."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from signal import SIGKILL

import pytest

from bench.equipment.live_robot import wait_for
from bench.faults.live_stage import LiveStage, live_stage
from fairlead.deploy.credentials import find_secrets, forget_secrets
from fairlead.deploy.process_table import is_trusted_at
from fairlead.messages import GateState
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.access.intruder import NOBODY
from tests.cli.command import fairlead

pytestmark = [
    pytest.mark.processes,
    pytest.mark.timeout(240),
    pytest.mark.skipif(os.getuid() != 0, reason="only root can become another user"),
]

AWAY = "state_assembler"
FILE = repo_root() / "compose" / "panda_mobile_sim.yaml"
LISTENER = (
    f"import os, socket, sys; os.setresuid({NOBODY}, {NOBODY}, {NOBODY}); "
    "family = socket.AF_INET6 if ':' in sys.argv[2] else socket.AF_INET; "
    "s = socket.create_server((sys.argv[2], int(sys.argv[1])), family=family); "
    "print('listens', flush=True); sys.stdin.read()"
)


def port_of(robot: LiveStage, service: str) -> str:
    return robot.client.deployment.services[service].listen.rpartition(":")[2]


@contextmanager
def process(*words: str) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [sys.executable, *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as one:
        try:
            assert one.stdout is not None and one.stdout.readline() == "listens\n"
            yield one
        finally:
            one.kill()


def lines_of(relay: subprocess.Popen[str], *keys: str) -> list[str]:
    """What it says to its end."""
    out, _ = relay.communicate("".join(f"{key}\n" for key in keys), 120.0)
    return out.splitlines()


def test_a_runners_proof_that_is_passed_on_gives_no_right(tmp_path: Path) -> None:
    with live_stage(tmp_path) as robot:
        keys = robot.client.keys
        robot.signal(AWAY, SIGKILL)
        asked = [keys.gate_status, keys.gate_command("arm")]
        relay = ["-m", "tests.access.relay", port_of(robot, AWAY), port_of(robot, "safety")]
        with process(*relay, "runner") as other:
            assert lines_of(other, *asked) == ["passed on", "link", "0", "0"]
        own = find_secrets(keys, ["runner"]).session_id("runner")
        with process(*relay, "runner", own) as same:
            assert lines_of(same, *asked) == ["passed on"], "the runner has its link already"
        assert robot.client.gate_status().state == GateState.DISARMED
        wait_for(lambda: "runner" in robot.client.alive, "nobody lost the runner")


def test_no_tool_and_no_service_proves_its_name_to_another_user(tmp_path: Path) -> None:
    scratch = make_scratch(FILE, tmp_path / "state", ScratchOptions())
    deployment, listen = scratch.deployment, scratch.deployment.services[AWAY].listen
    port = listen.rpartition(":")[2]
    said = f"{AWAY}: another user listens on its port {port} and could act in the name of"
    with process("-c", LISTENER, port, "127.0.0.1"):
        assert listen not in deployment.tool_endpoints().connect
        status = fairlead("status", "--deployment", str(scratch.file), state=tmp_path)
        words = ["service", str(scratch.file), "runner", "--state-dir", str(tmp_path / "runner")]
        runner = fairlead(*words, state=tmp_path)
    assert f"not connected: {said}" in status.stderr
    assert runner.returncode == 1 and said in runner.stdout + runner.stderr
    assert listen in deployment.tool_endpoints().connect
    forget_secrets(deployment.keys)


def test_the_gate_proves_its_name_to_no_hal_of_another_user(tmp_path: Path) -> None:
    scratch = make_scratch(FILE, tmp_path / "state", ScratchOptions())
    port = scratch.deployment.services["hal"].listen.rpartition(":")[2]
    with process("-c", LISTENER, port, "127.0.0.1"):
        words = ["service", str(scratch.file), "safety", "--state-dir", str(tmp_path / "gate")]
        gate = fairlead(*words, state=tmp_path)
    assert gate.returncode == 1
    assert f"safety: hal: another user listens on its port {port}" in gate.stderr
    forget_secrets(scratch.deployment.keys)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as free:
        return int(free.getsockname()[1])


@pytest.mark.parametrize(
    ("his", "is_his"),
    [("127.0.0.1", True), ("0.0.0.0", True), ("127.0.0.2", False), ("::1", False)],  # noqa: S104
)
def test_who_listens_at_an_address_is_asked_of_that_address(his: str, is_his: bool) -> None:
    port = free_port()
    place = ("127.0.0.1", port)
    with process("-c", LISTENER, str(port), his):
        assert is_trusted_at([place]) == ({place: False} if is_his else {})
        if not is_his:
            with socket.create_server(place):
                assert is_trusted_at([place]) == {place: True}


def test_ones_own_listener_elsewhere_is_no_reason_to_trust() -> None:
    port = free_port()
    with process("-c", LISTENER, str(port), "127.0.0.1"), socket.create_server(("127.0.0.2", port)):
        places = [("127.0.0.1", port), ("127.0.0.2", port), ("localhost", port)]
        assert is_trusted_at(places) == {places[0]: False, places[1]: True, places[2]: False}
