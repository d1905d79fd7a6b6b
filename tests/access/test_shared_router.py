"""One router for several robots: no message of one reaches another, and each keeps its own port."""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing, suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from queue import Queue
from typing import Any

import pytest
import yaml

from bench.equipment.live_robot import wait_for
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.shared_router import router_endpoints
from fairlead.errors import ConfigError
from fairlead.messages import JointState
from fairlead.paths import ACCESS_VARIABLE, repo_root
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.certificates.authority import Authority
from fairlead_tools.supervisor.this_host import free_ports

SOURCE = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"
WAIT_S = 60.0
STATES, STATE = 1000, bytes(200)
QUIET_BYTES = 5_000
"""Of a link that only keeps itself alive, for a minute."""


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Deployment]:
    monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path / "access"))
    content = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
    content |= {"hosts": {"robot": "127.0.0.1", "gpu": "127.0.0.2"}}
    found = []
    for name, port in zip(("left", "right"), free_ports(2), strict=True):
        content |= {"id": name, "router": {"host": "robot", "port": port}}
        file = tmp_path / f"{name}.yaml"
        file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        found.append(load_deployment(file))
        Authority(found[-1]).new(datetime.now(UTC), days=1)
    return found


def received(port: int) -> int:
    """Bytes that came over this process's links to a port, as the kernel counts them."""
    total = 0
    for descriptor in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # a file, or one that listens
            link = socket.socket(fileno=int(descriptor.name))
            try:
                if link.getpeername()[1] == port:
                    info = link.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 136)
                    total += struct.unpack_from("<Q", info, 128)[0]
            finally:
                link.detach()
    return total


def test_what_one_robot_says_comes_to_its_own_and_not_one_byte_of_it_to_another(
    robots: Sequence[Deployment],
) -> None:
    with ExitStack() as stack:

        def opened(endpoints: Endpoints) -> ZenohBus:
            return stack.enter_context(closing(ZenohBus(endpoints)))

        heard: dict[str, Queue[Sample]] = {one.id: Queue() for one in robots}
        opened(router_endpoints(robots))
        for one in robots:
            opened(one.endpoints("safety")).subscribe(one.keys.joints, heard[one.id].put)
        hals = {one.id: opened(one.endpoints("hal")) for one in robots}
        for here, there in (robots, robots[::-1]):
            before = received(here.routed.port), received(there.routed.port)
            states = hals[here.id].publisher(here.keys.joints, JointState, Qos.HOT)

            def arrives(put: Callable[[bytes], None], at: Queue[Sample]) -> bool:
                put(STATE)
                return not at.empty()

            wait_for(partial(arrives, states.put_bytes, heard[here.id]), f"a state of {here.id}")
            for _ in range(STATES):
                states.put_bytes(STATE)
                heard[here.id].get(timeout=WAIT_S)
            assert received(here.routed.port) - before[0] > STATES * len(STATE)
            assert received(there.routed.port) - before[1] < QUIET_BYTES


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "the same id": ({"id": "left"}, "router: left and left have the same id; each robot needs its"),
    "the same port": (
        {"router": None},
        "left and right have the same router.port; each robot needs",
    ),
    "open beside closed": ({"access": "open"}, "access of right is open and of left closed; a rou"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_router_does_not_start_for_robots_with(what: str, robots: Sequence[Deployment]) -> None:
    left, right = robots
    change, text = REFUSED[what]
    if "router" in change:
        change = {"router": left.router}
    with pytest.raises(ConfigError, match=text):
        router_endpoints([left, right.model_copy(update=change)])


def test_certificates_where_an_endpoint_cannot_name_them_are_refused(
    robots: Sequence[Deployment], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = (tmp_path / "access").rename(tmp_path / "a;b")
    monkeypatch.setenv(ACCESS_VARIABLE, str(folder))
    with pytest.raises(ConfigError, match=r"Zenoh takes no path with \? # ;; FAIRLEAD_ACCESS nam"):
        router_endpoints(robots)
    folder.rename(tmp_path / "access")


def test_a_name_that_no_certificate_can_have_is_said_with_the_file(tmp_path: Path) -> None:
    content = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
    content["id"] = "r" * 50
    file = tmp_path / "deployment.yaml"
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"fl/r+/state_assembler is longer than the 64 signs"):
        load_deployment(file)
    file.write_text(yaml.safe_dump(content | {"access": "open"}), encoding="utf-8")
    assert load_deployment(file).id == content["id"]
