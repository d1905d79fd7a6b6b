"""What live sessions let through is what the table says, whoever tries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Literal

import pytest

from fairlead.deploy.credentials import forget_secrets
from fairlead.paths import repo_root
from fairlead.wire.endpoints import Endpoints
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch
from tests.access.live_party import Found
from tests.access.party import STRANGERS, Party, Passed, endpoints_of, wildcards
from tests.access.walk import Walk, Walker

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

Access = Literal["closed", "open"]

SOURCE = repo_root() / "compose" / "panda_mobile_navigation.yaml"


SERVICES = 5
NTH = 20
"""Open, everything comes to everybody, so fewer keys show it."""


@contextmanager
def walker_of(folder: Path, access: Access, nth: int = 1) -> Iterator[Walker]:
    options = ScratchOptions(access=access, localiser="tracker")
    scratch = make_scratch(SOURCE, folder / "state", options)
    walker = Walker(scratch.file, scratch.deployment, nth)
    with walker.running():
        yield walker
    forget_secrets(scratch.deployment.keys)


def proof_of(access: Mapping[str, Any]) -> Mapping[str, Any]:
    """What of a party's access proves its name."""
    return {name: part for name, part in access.items() if name != "access_control"}


def whole_walk(folder: Path, access: Access, nth: int = 1) -> Walk:
    """Everybody tries everything: who keeps to the rules, and who does not."""
    with walker_of(folder, access, nth) as walker:
        names, services = walker.parties.names, list(walker.parties.services)
        proofs = {name: proof_of(endpoints_of(walker.deployment, name).access) for name in names}
        for name in names:
            walker.honest(name)
        for name in names:
            walker.dialler(name, proofs[name])
        for stranger, proof in STRANGERS.items():  # where nobody asks for a proof, one is no use
            walker.stranger(stranger, proof if access == "closed" else {})
        for name in services:
            walker.listener(name, proofs[name])
    print(walker.walk)
    return walker.walk


def test_closed_nothing_passes_but_what_the_table_says(tmp_path: Path) -> None:
    walk = whole_walk(tmp_path, "closed")
    assert (walk.breaches, walk.lost, walk.links) == (set(), set(), 0)
    assert walk.right > 600


@pytest.mark.thorough
def test_open_the_same_walk_finds_a_breach_of_each_kind_in_each_step(tmp_path: Path) -> None:
    walk = whole_walk(tmp_path, "open", NTH)
    assert walk.links == len(STRANGERS) * SERVICES
    assert walk.stopped == {}


@pytest.mark.parametrize(("access", "is_seen"), [("closed", False), ("open", True)])
def test_of_an_admin_space_that_is_on_the_probe_sees_what_access_lets_through(
    tmp_path: Path, access: Access, is_seen: bool
) -> None:
    scratch = make_scratch(SOURCE, tmp_path / "state", ScratchOptions(access=access))
    deployment, found = scratch.deployment, Found()
    hal = endpoints_of(deployment, "hal").config() | {"adminspace": {"enabled": True}}
    proof = proof_of(endpoints_of(deployment, "operator").access)
    dials = Endpoints(connect=[deployment.listen("hal")], mode="client", access=proof)
    status = deployment.parties.keys.hal_status
    asked = [*wildcards(deployment.parties), status]  # the last has its answer after all others

    def answers(passed: set[Passed], start: str) -> set[str]:
        return {p.key for p in passed if p.message == "reply" and p.key.startswith(start)}

    with (
        closing(Party("hal", hal, [], [status], found.add)),
        closing(Party("operator", dials.config(), asked, [], found.add)) as operator,
    ):
        operator.act()
        passed = found.settled(lambda passed: status in answers(passed, status))
    assert status in answers(passed, status)
    assert bool(answers(passed, "@/")) == is_seen
    forget_secrets(deployment.keys)
