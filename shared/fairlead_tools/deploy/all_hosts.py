"""Asks every host of a deployment what it finds of itself, and compares the answers."""

from __future__ import annotations

import json
import shlex
import subprocess
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from itertools import combinations, product
from pathlib import Path

from pydantic import ValidationError

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import port_of
from fairlead.deploy.shared_router import check_shared
from fairlead.errors import ConfigError, ServiceError
from fairlead_tools.deploy.host_report import HostReport, report_this
from fairlead_tools.supervisor.this_host import is_own_address

ANSWER_S = 60.0
CLOCK_S = 3600.0
"""Certificates begin and end by the clock."""


def ask_host(file: Path, deployment: Deployment, host: str, reach: str, program: str) -> HostReport:
    """What a host finds of itself: this machine if the address is its own, else as asked there.

    Args:
        reach: how a command is run there, as on a command line; ``{address}`` is the host's.
        program: how fairlead is called there.

    Raises:
        ConfigError: ``reach`` has other braces.
        ServiceError: it cannot be asked.
    """
    address = deployment.hosts[host]
    if is_own_address(host, address):
        return report_this(file, deployment, host)
    try:
        words = shlex.split(reach.format(address=address))
    except (ValueError, KeyError, IndexError):
        raise ConfigError(f"--reach: expected words and {{address}}, got {reach!r}") from None
    asked = [
        *shlex.split(program),
        "deploy",
        "check",
        str(file.absolute()),
        "--host",
        host,
        "--json",
    ]
    by_hand = f"; by hand, there: {shlex.join(asked[:-1])}"
    try:
        done = subprocess.run(
            [*words, *map(shlex.quote, asked)],
            stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=ANSWER_S, check=False,
        )  # fmt: skip
        [answer] = json.loads(done.stdout)["hosts"]
        its, mine = answer["versions"]["fairlead"], version("fairlead")
        try:
            return HostReport.model_validate(answer)
        except ValidationError:
            if its == mine:
                raise
        raise ServiceError(
            f"host {host}: answers as another version does: it has fairlead {its}, this machine "
            f"{mine}: install the same on both"
        )
    except subprocess.TimeoutExpired:
        raise ServiceError(f"host {host}: no answer within {ANSWER_S:g} s{by_hand}") from None
    except OSError as error:
        raise ServiceError(f"host {host}: cannot be asked: {error}{by_hand}") from None
    except (ValueError, KeyError, TypeError, ValidationError):
        raise ServiceError(f"host {host}: cannot be asked: {_said(done)}{by_hand}") from None


def _said(done: subprocess.CompletedProcess[str]) -> str:
    """On one line."""
    text = done.stderr.strip() or done.stdout.strip() or f"status {done.returncode}"
    return "; ".join(text[-500:].splitlines())


def compare(deployment: Deployment, reports: Sequence[HostReport]) -> Iterator[str]:
    """What is not the same on all hosts and has to be, each with what to do."""
    first, *others = reports
    for one in others:
        both = f"hosts {first.host} and {one.host}"
        for name, mine in first.versions.items():
            if mine != (its := one.versions.get(name, "none")):
                yield f"{both} have {name} {mine} and {its}: install the same on both"
        if first.file != one.file:
            yield f"{both} have different deployment files: copy it from one to the other"
        if first.robot != one.robot:
            yield (
                f"{both} have different robots {deployment.robot}: copy robots/{deployment.robot} "
                "from one to the other, or install the same package"
            )
        if first.trusted and one.trusted and first.trusted != one.trusted:
            yield (
                f"{both} have certificates of different makes: fairlead certs new on one machine "
                "alone, and copy to each host its folder"
            )
        if abs(first.clock_s - one.clock_s) > CLOCK_S:
            apart = abs(first.clock_s - one.clock_s) / 3600
            yield f"{both} have clocks {apart:.1f} h apart: set them"
    yield from _different_skills(deployment, {one.host: one for one in reports})


def router_problems(deployments: Sequence[Deployment]) -> Iterator[str]:
    """Why robots whose routers are on one machine could not share one."""
    routed = [one for one in deployments if one.router is not None]
    for one, other in combinations(routed, 2):
        if one.hosts[one.routed.host] == other.hosts[other.routed.host]:
            try:
                check_shared([one, other])
            except ConfigError as error:
                yield str(error)


def peer_problems(deployments: Sequence[Deployment]) -> Iterator[str]:
    """Why robots without a router could not all run on this machine."""
    for one, other in combinations([each for each in deployments if each.router is None], 2):
        if one.keys == other.keys:
            yield f"{one.id} and {other.id} have the same id; each robot needs its own"
        for (name, mine), (theirs, its) in product(one.services.items(), other.services.items()):
            if mine.listen and its.listen and port_of(mine.listen) == port_of(its.listen):
                yield (
                    f"{one.id} and {other.id} both listen on port {port_of(its.listen)} "
                    f"({name}, {theirs}); give one another port"
                )


def _different_skills(deployment: Deployment, reports: dict[str, HostReport]) -> Iterator[str]:
    """A runner's skills that its assembler would refuse."""
    specs = deployment.services.values()
    assemblers = [spec.host for spec in specs if spec.run == "state_assembler"]
    runners = [spec.host for spec in specs if spec.run == "skill_runner"]
    for assembler, runner in dict.fromkeys(product(assemblers, runners)):
        if not {assembler, runner} <= reports.keys():
            continue
        theirs = reports[assembler].skills
        for skill, mine in reports[runner].skills.items():
            if mine != (its := theirs.get(skill, "none")):
                yield (
                    f"skill {skill} is {mine} on host {runner} and {its} on host {assembler}: "
                    "fairlead skill install the same on both"
                )
