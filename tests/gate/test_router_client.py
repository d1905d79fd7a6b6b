"""The gate as a client of a router: waits for it, and is still the only one of its robot."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.running_gate import ROBOT, RunningGate
from fairlead.keys import Keys
from fairlead.messages import GateStatus, StatusQuery, decode
from fairlead.paths import gate_binary
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports

pytestmark = pytest.mark.processes


@pytest.fixture
def gates(config: Path, tmp_path: Path) -> Iterator[ClientGates]:
    gates = ClientGates(config, tmp_path)
    yield gates
    gates.close()


class ClientGates:
    """Gates that are clients of a router at one port, and that router."""

    def __init__(self, config: Path, folder: Path) -> None:
        self.endpoint = f"tcp/127.0.0.1:{free_ports(1)[0]}"
        self._config, self._folder = config, folder
        self._buses: list[ZenohBus] = []
        self._gates: list[RunningGate] = []

    def router(self) -> ZenohBus:
        return self._kept(ZenohBus(Endpoints(listen=[self.endpoint], mode="router")))

    def client(self) -> ZenohBus:
        return self._kept(ZenohBus(Endpoints(connect=[self.endpoint], mode="client")))

    def start(self, state: str) -> RunningGate:
        gate = RunningGate(self._config, self._folder / state, router=self.endpoint)
        self._gates.append(gate)
        return gate

    def close(self) -> None:
        for gate in self._gates:
            gate.close()
        for bus in self._buses:
            bus.close()

    def _kept(self, bus: ZenohBus) -> ZenohBus:
        self._buses.append(bus)
        return bus


def test_a_gate_waits_for_its_router_says_so_and_is_reached_through_it(gates: ClientGates) -> None:
    gate = gates.start("state")
    gate.wait_line(f"WARNING safety: waiting for the router {gates.endpoint}")
    gates.router()
    gate.wait_line("ready")
    answer = gates.client().query(Keys(ROBOT).gate_status, StatusQuery(), 5.0)
    assert decode(GateStatus, answer).robot == ROBOT
    assert gate.stop() == 0


def test_a_gate_that_waits_for_its_router_ends_when_asked(gates: ClientGates) -> None:
    gate = gates.start("state")
    gate.wait_line("waiting for the router")
    gate.process.send_signal(signal.SIGTERM)
    assert gate.wait_exit() == 0
    assert gate.lines[-1] == "INFO safety: ends on SIGTERM before it reached the router"


def test_a_second_gate_behind_the_same_router_refuses_to_start(gates: ClientGates) -> None:
    gates.router()
    gates.start("first").wait_line("ready")
    second = gates.start("second")
    assert second.wait_exit() == 1
    assert second.lines[-1] == (
        "ERROR fairlead-safety: another gate already serves the robot panda_mobile; "
        "see: fairlead ps"
    )


def test_a_gate_is_reached_again_after_its_router_was_replaced(gates: ClientGates) -> None:
    router = gates.router()
    gates.start("state").wait_line("ready")
    router.close()
    gates.router()
    client = gates.client()
    token = Keys(ROBOT).alive("safety")
    while not client.is_declared(token):  # the test's timeout is the deadline
        pass
    assert decode(GateStatus, client.query(Keys(ROBOT).gate_status, StatusQuery(), 5.0)).robot


def test_a_gate_is_a_peer_or_a_client_never_both() -> None:
    words = ["--robot", ROBOT, "--config", "c", "--state-dir", "s", "--router", "tcp/127.0.0.1:1"]
    done = subprocess.run(
        [gate_binary(), *words, "--listen", "tcp/127.0.0.1:2"],
        capture_output=True, text=True, timeout=10, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "--listen or --router: expected one of them" in done.stdout
