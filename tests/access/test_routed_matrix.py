"""What passes a router between two hosts is what the table says, whoever tries."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import pytest
import yaml

from bench.equipment.bad_certificates import UNKNOWN_NAME, make_certificates
from fairlead.deploy.certificates import certificates_dir
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.paths import ACCESS_VARIABLE, repo_root
from fairlead.wire.endpoints import Endpoints
from fairlead_tools.certificates.authority import Authority
from fairlead_tools.supervisor.this_host import free_ports
from tests.access.certified import PEOPLE
from tests.access.party import endpoints_of
from tests.access.routed_walk import RoutedWalker
from tests.access.walk import Walk
from tests.system.two_networks import HOSTS, TwoNetworks, two_networks

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]

SOURCE = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"
Access = Literal["closed", "open"]
NTH = 20
"""Open, everything comes to everybody, so fewer keys show it."""
DEFAULT_PEER = "a default peer"
OTHER = "the other robot's"


@pytest.fixture
def network() -> Iterator[TwoNetworks]:
    with two_networks() as network:
        yield network


@contextmanager
def walker_of(
    network: TwoNetworks, folder: Path, access: Access, nth: int
) -> Iterator[RoutedWalker]:
    """All with their certificates, strangers of every kind on the GPU host, and another robot."""
    content = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
    content |= {"hosts": network.addresses, "access": access, "localiser": "tracker"}
    content["people"] = PEOPLE
    deployments, files = [], []
    for name, port in zip(("walk", "other"), free_ports(2), strict=True):
        content |= {"id": f"{name}{os.getpid()}", "router": {"host": "robot", "port": port}}
        files.append(folder / f"{name}.yaml")
        files[-1].write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        deployments.append(load_deployment(files[-1]))
    deployment, other = deployments
    folders = {host: folder / host for host in HOSTS}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(ACCESS_VARIABLE, str(folders["robot"]))
        proofs: dict[str, dict[str, Any]] = {}
        if access == "closed":
            proofs = make_certificates(deployment, "gpu")
            made = certificates_dir(deployment.keys)
            there = folders["gpu"] / made.relative_to(folders["robot"])
            for name in ("gpu", *PEOPLE):
                shutil.copytree(made / name, there / name)
            Authority(other).new(datetime.now(UTC), days=1)
        walker = RoutedWalker(network, files[0], deployment, folders, files[1:], nth)
        found = strangers(deployment.router_endpoint, proofs) | others(other)
        with walker.running(found):
            yield walker


def others(other: Deployment) -> dict[str, Endpoints]:
    """Everybody of another robot, keeping to no rule."""
    found = {}
    for name in other.parties.names:
        one = endpoints_of(other, name)
        proof = {key: part for key, part in one.access.items() if key == "transport"}
        found[f"{OTHER} {name}"] = replace(one, access=proof)
    return found


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


def whole_walk(
    network: TwoNetworks, folder: Path, access: Access, nth: int = 1
) -> tuple[Walk, set[str]]:
    """Everybody tries everything; also, which strangers had a link."""
    with walker_of(network, folder, access, nth) as walker:
        for name in walker.parties.names:
            walker.honest(name)
            walker.lawless(name)
        walker.strange()
    print(f"{network.why_loopback or 'two network namespaces'}: {walker.walk}")
    return walker.walk, walker.linked


def test_closed_nothing_passes_but_what_the_table_says(
    network: TwoNetworks, tmp_path: Path
) -> None:
    walk, linked = whole_walk(network, tmp_path, "closed")
    assert (walk.breaches, walk.lost) == (set(), set())
    others = {name for name in linked if name.startswith(OTHER)}
    assert linked - others == {UNKNOWN_NAME}
    assert others == {name for name in walk.steps if name.startswith(OTHER)}
    assert walk.right > 600


@pytest.mark.thorough
def test_open_the_same_walk_finds_a_breach_of_each_kind_in_each_step(
    network: TwoNetworks, tmp_path: Path
) -> None:
    walk, linked = whole_walk(network, tmp_path, "open", NTH)
    assert DEFAULT_PEER in linked
    assert walk.stopped == {}
    receivers = {one.receiver for one in walk.breaches}
    assert receivers >= set(walk.steps), "each of them also hears what is not for it"
