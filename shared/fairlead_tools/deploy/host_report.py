"""What one machine finds of itself as a host of a deployment, before anything starts there."""

from __future__ import annotations

import hashlib
import socket
import time
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from fairlead.deploy.access import OPERATOR
from fairlead.deploy.certificates import find_certificate, trusted_mark
from fairlead.deploy.deployment import Deployment
from fairlead.errors import FairleadError
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import load_skill, skill_ids
from fairlead_tools.supervisor.before_start import checks
from fairlead_tools.supervisor.this_host import check_places_free, choose_host

REACH_S = 3.0
HASH_DIGITS = 16


class HostReport(BaseModel):
    """A host's own problems, and what has to be the same on all hosts.

    Attributes:
        host: "" where the deployment has no hosts.
        processes: what is started there.
        versions: of fairlead and of what messages pass through.
        file: SHA-256 of the deployment file, as all hashes the first digits.
        robot: hash of the robot.
        skills: hash of each skill for the robot.
        trusted: mark of the router's certificates.
        clock_s: seconds since 1970.
        problems: what keeps it from starting, each with what to do.
        warnings: what does not.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    host: str
    processes: list[str]
    versions: dict[str, str]
    file: str
    robot: str = ""
    skills: dict[str, str] = {}
    trusted: str = ""
    clock_s: float
    problems: list[str]
    warnings: list[str]


def report_this(file: Path, deployment: Deployment, host: str | None) -> HostReport:
    """Check this machine as one host, or as the only one.

    Raises:
        ConfigError: none was named of several hosts, or one that the file does not have.
        OSError: the file cannot be read.
    """
    problems: list[str] = []
    warnings: list[str] = []
    try:
        choose_host(deployment, host)
    except FairleadError as error:
        if host not in deployment.hosts:
            raise
        problems.append(str(error))
    processes = deployment.processes(host)
    for check in checks(file, deployment, processes):
        try:
            warnings += check()
        except FairleadError as error:
            problems.append(str(error))
    for name in processes:
        try:
            check_places_free(deployment, [name])
        except FairleadError as error:
            problems.append(str(error))
    problems += _router_problems(deployment, host)
    warnings += _tool_warnings(deployment, host)
    robot: str = ""
    skills: dict[str, str] = {}
    try:
        robot, skills = _hashes(deployment)
    except FairleadError as error:
        problems.append(str(error))
    return HostReport(
        host=host or "",
        processes=processes,
        versions={name: version(name) for name in ("fairlead", "eclipse-zenoh")},
        file=hashlib.sha256(file.read_bytes()).hexdigest()[:HASH_DIGITS],
        robot=robot,
        skills=skills,
        trusted=trusted_mark(deployment.keys, host or ""),
        clock_s=time.time(),
        problems=list(dict.fromkeys(problems)),
        warnings=list(dict.fromkeys(warnings)),
    )


def _hashes(deployment: Deployment) -> tuple[str, dict[str, str]]:
    """Of the robot and of each skill for it that can be read."""
    robot, skills = load_robot(deployment.robot), {}
    for name in skill_ids():
        try:
            skill = load_skill(name)
        except FairleadError:
            continue  # a runner leaves it out; one that the file asks for is refused
        if robot.id in skill.embodiments:
            skills[name] = skill.skill_hash.hex()[:HASH_DIGITS]
    return robot.robot_hash.hex()[:HASH_DIGITS], skills


def _tool_warnings(deployment: Deployment, host: str | None) -> Iterable[str]:
    """Whether the tools of this host can prove that they are the operator's."""
    if host is not None and (host, OPERATOR) in deployment.certified:
        try:
            find_certificate(deployment.keys, [host], OPERATOR)
        except FairleadError as error:
            yield f"{host}: no tool reaches the robot from here: {error}"


def _router_problems(deployment: Deployment, host: str | None) -> Iterable[str]:
    """Whether the router's host can be reached from here. That nobody listens yet is right."""
    router = deployment.router
    if router is None or router.host == host:
        return
    address = deployment.hosts[router.host]
    try:
        socket.create_connection((address, router.port), REACH_S).close()
    except ConnectionRefusedError:
        return
    except OSError as error:
        yield (
            f"{host}: cannot reach the router's host {router.host} at {address}, port "
            f"{router.port}: {error}; correct hosts.{router.host}, or open the port there"
        )
