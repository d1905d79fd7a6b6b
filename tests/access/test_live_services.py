"""Services that run take and tell nothing that is not an identity's own; open they do."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from bench.faults.live_stage import Changes, LiveStage, live_stage
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.frame_sender import FrameSender
from tests.access.intruder import NOBODY, Found, Heard, Intruders, Said
from tests.access.party import STRANGERS, endpoints_of, every_key
from tests.access.walk import Table

pytestmark = [pytest.mark.processes, pytest.mark.timeout(240)]

STATUSES = 3
"""So many of the gate's are waited for: by then it has also said what else it says."""
UNREADABLE = "that cannot be read"


@pytest.fixture(scope="module")
def closed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    with live_stage(tmp_path_factory.mktemp("closed")) as robot:
        yield robot


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveStage]:
    with live_stage(tmp_path_factory.mktemp("opened"), Changes(access="open")) as robot:
        yield robot


@pytest.fixture
def as_nobody() -> int:
    """Another user's id."""
    if os.getuid():
        pytest.skip("only root can become another user")
    return NOBODY


@dataclass(frozen=True)
class Tried:
    """What came of it.

    found: by identity and service, what an intruder there has found.
    counted: by identity, how many of its frames the gate could not read.
    """

    table: Table
    found: Mapping[tuple[str, str], Found]
    counted: Mapping[str, int]

    def heard(self, name: str) -> set[Heard]:
        """At all services, but for what the identity may hear."""
        mine = {Heard("put", key) for key in self.table.may(name, "read", "published")}
        mine |= {Heard("token", key) for key in self.table.may(name, "read", "token")}
        return {one for (who, _), f in self.found.items() if who == name for one in f.heard} - mine


def proofs(robot: LiveStage) -> dict[str, Mapping[str, Any]]:
    """Of each identity."""
    deployment = robot.client.deployment
    found: dict[str, Mapping[str, Any]] = {}
    for name in deployment.parties.names:
        access = endpoints_of(deployment, name).access
        found[name] = {part: one for part, one in access.items() if part == "transport"}
    return found


def tried(
    robot: LiveStage, folder: Path, who: Mapping[str, Mapping[str, Any]], user: int | None = None
) -> Tried:
    """Each dials each service, publishes and asks whatever it may not, and hears."""
    deployment = robot.client.deployment
    keys = every_key(deployment.parties)
    table = Table(robot.robot.scratch.file, keys)
    pairs = [(name, service) for name in who for service in deployment.services]
    configs, said = {}, {}
    for name, service in pairs:
        listen = deployment.listen(service)
        one = Endpoints(connect=[listen], mode="client", access=who[name])
        configs[f"{name}@{service}"] = one.config()
        put, ask = set(table.may(name, "write", "published")), table.may(name, "write", "query")
        said[f"{name}@{service}"] = Said(sorted({*keys} - put), sorted({*keys} - {*ask}))
    counted = {}
    with closing(Intruders(folder / "intruders.json", configs, said, user)) as intruders:
        for name in who:
            before = unread(robot)
            for service in deployment.services:
                intruders.act(f"{name}@{service}")
            counted[name] = unread(robot) - before
        with robot.client.gate_statuses() as statuses:
            for _ in range(STATUSES):
                next(iter(statuses))
        found = intruders.end()
    return Tried(table, {pair: found["@".join(pair)] for pair in pairs}, counted)


def unread(robot: LiveStage) -> int:
    """How many frames the gate could not read."""
    return dict(robot.client.gate_status().counters).get("G001", 0)


def log_of(robot: LiveStage, service: str) -> str:
    return (robot.robot.scratch.state_dir / "logs" / f"{service}.log").read_text(encoding="utf-8")


def test_closed_an_identity_is_told_nothing_and_nobody_takes_what_is_not_its_own(
    closed: LiveStage, tmp_path: Path
) -> None:
    result = tried(closed, tmp_path, proofs(closed))
    for name, counted in result.counted.items():
        assert (name, result.heard(name), counted) == (name, set(), 0)
    assert not closed.client.gate_status().stop_ids
    for service in closed.client.deployment.services:
        assert UNREADABLE not in log_of(closed, service)
    joints = Heard("put", closed.client.keys.joints)
    assert joints in result.found["operator", "hal"].heard, "who may hear does"


def test_open_each_identity_is_told_and_taken_for_anybody(
    opened: LiveStage, tmp_path: Path
) -> None:
    result = tried(opened, tmp_path, proofs(opened))
    for name, counted in result.counted.items():
        heard = result.heard(name)
        assert counted > 0, name
        assert {one.message for one in heard} >= {"put", "reply"}, name
    for kind in ("Lease", "SafeChunk", "StopLevel"):
        assert f"{kind} {UNREADABLE}" in log_of(opened, "hal")


@pytest.mark.parametrize("is_own", [True, False])
def test_closed_who_has_no_password_has_no_link_and_another_user_has_none_with_one(
    closed: LiveStage, tmp_path: Path, as_nobody: int, is_own: bool
) -> None:
    password = dict(proofs(closed)["operator"]["transport"]["auth"]["usrpwd"])
    del password["dictionary_file"]  # that only this user can read
    told = {"transport": {"auth": {"usrpwd": password}}}
    user = None if is_own else as_nobody
    result = tried(closed, tmp_path, {**STRANGERS, "operator": told}, user)
    for name in STRANGERS if is_own else result.counted:
        links = sum(one.links for (who, _), one in result.found.items() if who == name)
        assert (name, result.heard(name), result.counted[name], links) == (name, set(), 0, 0)
    joints = Heard("put", closed.client.keys.joints)
    assert (joints in result.found["operator", "hal"].heard) == is_own


def test_open_another_user_is_told_and_taken_for_anybody(
    opened: LiveStage, tmp_path: Path, as_nobody: int
) -> None:
    result = tried(opened, tmp_path, {"a default peer": {}}, as_nobody)
    assert Heard("put", opened.client.keys.joints) in result.heard("a default peer")
    assert result.counted["a default peer"] > 0


READER = """
import os, socket, sys
from fairlead.wire.frame_link import PACKET_MAX, address
name, user = sys.argv[1], int(sys.argv[2])
os.setresuid(user, user, user)
link = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
link.settimeout(10)
link.connect(address(name))
print("linked", flush=True)
print(len(link.recv(PACKET_MAX)))
"""


@pytest.mark.parametrize("is_own", [True, False])
def test_another_user_gets_no_pictures_from_shared_memory(as_nobody: int, is_own: bool) -> None:
    user = os.getuid() if is_own else as_nobody
    with closing(FrameSender()) as sender:
        words = [sys.executable, "-c", READER, sender.name, str(user)]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as reader:
            assert reader.stdout is not None
            assert reader.stdout.readline() == "linked\n"
            assert sender.send([b"a picture"]) == is_own
            assert bool(int(reader.stdout.read())) == is_own
