"""Our bytes against those of packages that others published: openpi-client and msgpack-numpy."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from fairlead.policy import Observation
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.remote import openpi_wire, rldx_wire
from fairlead_skill_runner.policies.remote.served_skill import told_of
from fairlead_skill_runner.policy_server import served_policy
from tests.peers.documents import SEEDS, document, same
from tests.peers.environment import peer
from tests.runner.policy_servers import OpenpiServer, openpi_actions
from tests.runner.served_skill import served

pytestmark = pytest.mark.processes

OPENPI = (openpi_wire.encode, openpi_wire.decode)
ND = (lambda made: rldx_wire.encode(made, "nd"), rldx_wire.decode)


@pytest.mark.parametrize(("wire", "ours"), [("openpi", OPENPI), ("nd", ND)])
def test_bytes_are_the_peer_s_and_each_reads_the_other_s(wire: str, ours: tuple[Any, Any]) -> None:
    encode, decode = ours
    lines = "".join(f"{encode(document(seed)).hex()}\n" for seed in SEEDS)
    done = subprocess.run(
        [*peer("peer_bytes"), wire], input=lines, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    for seed, line in zip(SEEDS, done.stdout.splitlines(), strict=True):
        found, theirs = line.split(" ")
        assert found == "ok", seed
        assert same(decode(bytes.fromhex(theirs)), document(seed)), seed
        assert encode(document(seed)).hex() == theirs, seed


def test_openpi_s_own_client_takes_our_small_server_for_one_of_openpi_s() -> None:
    """What the other tests try against that server is tried against what it stands for."""
    rows, keys = np.arange(12, dtype=np.float32).reshape(1, 12), []
    server = OpenpiServer(
        lambda request, n: openpi_actions(rows),
        guard=lambda link, asked: keys.append(asked.headers.get("Authorization")),
    )
    try:
        command = [*peer("peer_client"), server.address, "k3y"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        assert done.stdout == f"{{'who': 'test'}} {rows.tobytes().hex()}\n", done.stderr
        assert keys == ["Api-Key k3y"]
    finally:
        server.close()


@pytest.mark.parametrize("skill_id", ["oracle-counter-to-cabinet", "bc-reach-cube"])
def test_openpi_s_own_client_asks_a_skill_s_policy_with_the_pictures_that_it_sees(
    skill_id: str,
) -> None:
    skill = load_skill(skill_id)
    dim, rng = skill.state_contract.dim, np.random.default_rng(5)
    seen = {name: rng.uniform(0, 1, (3, 64, 64)).astype(np.float32) for name in skill.images}
    pixels = b"".join(picture.tobytes() for picture in seen.values())
    with served(skill.id, key="k3y") as address:
        command = [*peer("peer_client"), address, "k3y", str(dim), *seen]
        done = subprocess.run(command, input=pixels, capture_output=True, timeout=60)
    wanted = served_policy(skill).infer(Observation(1, np.full(dim, 0.5), "go", seen))
    assert isinstance(wanted, np.ndarray)
    told = {"fairlead": told_of(skill)}
    assert done.stdout.decode() == f"{told} {wanted.tobytes().hex()}\n", done.stderr.decode()


def test_the_peers_environment_is_not_ours() -> None:
    assert peer("peer_bytes")[0] != sys.executable
