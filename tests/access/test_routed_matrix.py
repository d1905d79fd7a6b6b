"""What passes a router between two hosts is what the table says, whoever tries."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import pytest
import yaml

from bench.equipment.bad_certificates import UNKNOWN_NAME, make_certificates
from fairlead.deploy.certificates import certificates_dir
from fairlead.deploy.deployment import load_deployment
from fairlead.paths import ACCESS_VARIABLE, repo_root
from fairlead.wire.endpoints import Endpoints
from fairlead_tools.supervisor.this_host import free_ports
from tests.access.routed_walk import RoutedWalker
from tests.system.two_networks import HOSTS, TwoNetworks, two_networks

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]

SOURCE = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"
DEFAULT_PEER = "a default peer"


@pytest.fixture
def network() -> Iterator[TwoNetworks]:
    with two_networks() as network:
        yield network


@contextmanager
def walker_of(
    network: TwoNetworks, folder: Path, access: Literal["closed", "open"]
) -> Iterator[RoutedWalker]:
    """All with their certificates, and strangers of every kind on the GPU host."""
    content = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
    content |= {"id": f"walk{os.getpid()}", "hosts": network.addresses, "access": access}
    content |= {"localiser": "tracker", "router": {"host": "robot", "port": free_ports(1)[0]}}
    file = folder / "deployment.yaml"
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    deployment = load_deployment(file)
    folders = {host: folder / host for host in HOSTS}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(ACCESS_VARIABLE, str(folders["robot"]))
        proofs: dict[str, dict[str, Any]] = {}
        if access == "closed":
            proofs = make_certificates(deployment, "gpu")
            made = certificates_dir(deployment.keys)
            there = folders["gpu"] / made.relative_to(folders["robot"])
            shutil.copytree(made / "gpu", there / "gpu")
        walker = RoutedWalker(network, file, deployment, folders)
        with walker.running(strangers(deployment.router_endpoint, proofs)):
            yield walker


def strangers(router: str, proofs: Mapping[str, Mapping[str, Any]]) -> dict[str, Endpoints]:
    """Whoever is no party, and how it dials the router."""
    plain = f"tcp/{router.partition('/')[2]}"
    found = {DEFAULT_PEER: Endpoints(connect=[router]), "plain TCP": Endpoints(connect=[plain])}
    for kind, proof in proofs.items():
        mode = "client" if kind == UNKNOWN_NAME else "peer"  # a client is not told what to send
        found[kind] = Endpoints(connect=[router], mode=mode, access=proof)
    for proof in proofs.values():
        tls = {**proof["transport"]["link"]["tls"], "enable_mtls": False}
        access = {"transport": {"link": {"tls": tls}}}
        found["no certificate"] = Endpoints(connect=[router], access=access)
    return found


def test_closed_nothing_passes_but_what_the_table_says(
    network: TwoNetworks, tmp_path: Path
) -> None:
    with walker_of(network, tmp_path, "closed") as walker:
        for name in walker.parties.names:
            walker.honest(name)
            walker.lawless(name)
        walker.strange()
    walk = walker.walk
    print(f"{network.why_loopback or 'two network namespaces'}: {walk}")
    assert (walk.breaches, walk.lost) == (set(), set())
    assert walker.linked == {UNKNOWN_NAME}
    assert walk.right > 600


def test_open_the_same_walk_finds_breaches(network: TwoNetworks, tmp_path: Path) -> None:
    with walker_of(network, tmp_path, "open") as walker:
        walker.honest("hal")
        walker.strange()
    print(walker.walk)
    assert DEFAULT_PEER in walker.linked
    for message in ("put", "delete", "query", "reply", "token"):
        assert any(p.message == message for p in walker.walk.breaches), message
    assert any(p.receiver == DEFAULT_PEER for p in walker.walk.breaches)
