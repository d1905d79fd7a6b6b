"""What live sessions let through is what the table says, whoever tries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import pytest

from fairlead.deploy.credentials import forget_secrets
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.access.party import endpoints_of
from tests.access.walk import Walker

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

SOURCE = repo_root() / "compose" / "panda_mobile_navigation.yaml"
STRANGERS: Mapping[str, Mapping[str, Any]] = {
    "a default peer": {},
    "a wrong password": {
        "transport": {"auth": {"usrpwd": {"user": "operator", "password": "0" * 64}}}
    },
    "an unknown name": {
        "transport": {"auth": {"usrpwd": {"user": "nobody", "password": "0" * 64}}}
    },
}


@contextmanager
def walker_of(folder: Path, access: Literal["closed", "open"]) -> Iterator[Walker]:
    options = ScratchOptions(access=access, localiser="tracker")
    scratch = make_scratch(SOURCE, folder / "state", options)
    walker = Walker(scratch.file, scratch.deployment)
    with walker.running():
        yield walker
    forget_secrets(scratch.deployment.keys)


def proof_of(access: Mapping[str, Any]) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """What of a party's access proves its name: to those it dials, to those that dial it."""
    dials = {name: part for name, part in access.items() if name == "transport"}
    return dials, {name: part for name, part in access.items() if name != "access_control"}


def test_closed_nothing_passes_but_what_the_table_says(tmp_path: Path) -> None:
    with walker_of(tmp_path, "closed") as walker:
        names, services = walker.parties.names, list(walker.parties.services)
        proofs = {name: proof_of(endpoints_of(walker.deployment, name).access) for name in names}
        for name in names:
            walker.honest(name)
        for name in names:
            walker.dialler(name, proofs[name][0])
        for stranger, access in STRANGERS.items():
            walker.stranger(stranger, access)
        for name in services:
            walker.listener(name, proofs[name][1])
    walk = walker.walk
    print(walk)
    assert (walk.breaches, walk.lost, walk.links) == (set(), set(), 0)
    assert walk.right > 600


def test_open_the_same_walk_finds_breaches(tmp_path: Path) -> None:
    with walker_of(tmp_path, "open") as walker:
        walker.honest("hal")
        [stranger] = [name for name, access in STRANGERS.items() if not access]
        walker.stranger(stranger, {})
    walk = walker.walk
    print(walk)
    assert walk.links == len(walker.parties.services)
    for message in ("put", "delete", "query", "reply", "token"):
        found = {p for p in walk.breaches if p.message == message}
        assert any(p.sender.startswith(stranger) for p in found), message
        assert any(p.receiver.startswith(stranger) for p in found), message
