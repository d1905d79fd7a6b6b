"""A link whose other end takes nothing any more: the router closes it without waiting."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
import yaml

from bench.equipment.live_robot import wait_for
from fairlead.messages import Heartbeat
from fairlead.paths import repo_root
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports
from tests.cli.command import fairlead_command, fairlead_environment

pytestmark = pytest.mark.processes

TWO_HOSTS = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"
LINGER_S = 10.0  # for so long Zenoh has the kernel block
FIN_WAIT1 = "04"
NOBODY = "0"  # the inode of a socket that no process has open
CLIENT = """
import signal, sys
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
bus = ZenohBus(Endpoints(connect=[sys.argv[1] + "#so_rcvbuf=4096"], mode="client"))
bus.subscribe("big", lambda sample: None)
bus.declare_token("subscribed")
signal.pause()
"""


def test_a_link_with_unsent_data_is_closed_without_holding_up_a_thread(tmp_path: Path) -> None:
    port = free_ports(1)[0]
    endpoint = f"tcp/127.0.0.1:{port}"
    with (
        router(tmp_path, port),
        closing(ZenohBus(Endpoints(connect=[endpoint], mode="client"))) as bus,
        ended(subprocess.Popen([sys.executable, "-c", CLIENT, endpoint], text=True)) as client,
    ):
        wait_for(lambda: bus.is_declared("subscribed"), "the client is there")
        client.send_signal(signal.SIGSTOP)
        big = bus.publisher("big", Heartbeat, Qos.HOT)

        def is_given_up() -> bool:
            big.put_bytes(bytes(100_000))
            return bool(closing_sockets(port))

        wait_for(is_given_up, "the router ends the silent link")
        what = "close() of the dead link has returned"
        wait_for(lambda: closing_sockets(port) == [NOBODY], what, LINGER_S / 2)


def closing_sockets(port: int) -> list[str]:
    """Inodes of the sockets on a port that still have to send what was written, and the end."""
    rows = [row.split() for row in Path("/proc/net/tcp").read_text(encoding="ascii").splitlines()]
    end = f":{port:04X}"
    return [row[9] for row in rows if row[1].endswith(end) and row[3] == FIN_WAIT1]


@contextmanager
def router(folder: Path, port: int) -> Iterator[None]:
    """``fairlead router``, once it listens."""
    content = yaml.safe_load(TWO_HOSTS.read_text(encoding="utf-8"))
    content["id"] = f"links{os.getpid()}"
    content |= {"hosts": {"robot": "127.0.0.1", "gpu": "127.0.0.2"}, "access": "open"}
    content["router"]["port"] = port
    file = folder / "deployment.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    process = subprocess.Popen(
        fairlead_command("router", str(file)),
        env=fairlead_environment(folder / "state"),
        stdout=subprocess.PIPE,
        text=True,
    )
    with ended(process):
        assert process.stdout is not None
        assert any("ready" in line for line in process.stdout)
        yield


@contextmanager
def ended(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """A process that is killed, frozen or not, when the test leaves it."""
    with process:
        try:
            yield process
        finally:
            process.kill()
