"""The command line and environment of each service of a deployment."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from fairlead.deploy.credentials import write_session
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.scheduling import realtime_words
from fairlead.deploy.service_spec import EXTERNAL
from fairlead.errors import ConfigError, expected
from fairlead.paths import gate_binary, gate_config
from fairlead.plugins import HALS
from fairlead.robot.manifest import load_robot

CommandBuilder = Callable[[Path, Deployment, str, Path], list[str]]
"""Gets the deployment's file and content, a service's name and its state folder."""

_MODULES = {
    "state_assembler": "fairlead_state_assembler",
    "skill_runner": "fairlead_skill_runner",
}
_HAL_MODULE = "fairlead.hal.serve"


def service_command(
    deployment_file: Path, deployment: Deployment, service: str, state_dir: Path
) -> list[str]:
    """What to execute for one service, or for the router.

    Raises:
        ConfigError: if the gate is not built or its file not compiled; for a HAL that no installed
            package has, or that somebody else starts; for a real-time priority that the system does
            not permit.
    """
    if service == ROUTER and deployment.router is not None:
        return [sys.executable, "-m", "fairlead_tools.cli.main", "router", str(deployment_file)]
    first = realtime_words(service, deployment.services[service].realtime_priority)
    if _is_gate(deployment, service):
        return [*first, *_gate_command(deployment, service, state_dir)]
    return [
        *first,
        *_program(deployment, service),
        "--deployment", str(deployment_file),
        "--service", service,
        "--state-dir", str(state_dir),
    ]  # fmt: skip


def _program(deployment: Deployment, service: str) -> list[str]:
    """What a Python service, or a HAL, is started with before its arguments."""
    spec = deployment.services[service]
    if spec.command:
        program, *words = spec.command
        if program != "python" and shutil.which(program) is None:
            who = deployment.who(service, "command")
            raise ConfigError(expected(who, "a program that this user may run", repr(program)))
        return [sys.executable if program == "python" else program, *words]
    if spec.run == EXTERNAL:
        raise ConfigError(
            f"{deployment.who(service, 'run')} is {EXTERNAL}: somebody else starts it"
        )
    if spec.is_hal:
        HALS.find(spec.run, deployment.who(service, "run"))
    return [sys.executable, "-m", _MODULES.get(spec.run, _HAL_MODULE)]


def check_gate_file(deployment: Deployment) -> None:
    """Ask the gate whether it would start on the deployment's gate file.

    Raises:
        ConfigError: it would not, in its own words; the gate is not built, its file not compiled;
            robot.yaml has numbers that nobody confirmed, and the profile is for hardware.
    """
    load_robot(deployment.robot).check_confirmed(deployment.profile)
    file = gate_config(deployment.robot, deployment.profile)
    asked = [str(gate_binary()), "check", str(file)]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        said = done.stdout.strip().rpartition("ERROR fairlead-safety: ")[2]
        raise ConfigError(said or f"{asked[0]}: {done.stderr.strip() or 'failed'}")


NEW_STATE = "--new-state"  # the gate's word for: this state folder is new, and that is right


def new_state_command() -> CommandBuilder:
    """As `service_command`, and the gate is told at its first start that its folder is new.

    Not when it is started again: a folder that vanished meanwhile is not right.
    """
    told: list[str] = []

    def build(file: Path, deployment: Deployment, service: str, state_dir: Path) -> list[str]:
        words = service_command(file, deployment, service, state_dir)
        if service in told or not _is_gate(deployment, service):
            return words
        told.append(service)
        return [*words, NEW_STATE]

    return build


def _is_gate(deployment: Deployment, service: str) -> bool:
    return service in deployment.services and deployment.services[service].run == "safety"


def _gate_command(deployment: Deployment, service: str, state_dir: Path) -> list[str]:
    endpoints = deployment.endpoints(service)
    command = [
        str(gate_binary()),
        "--robot", deployment.id,
        "--namespace", deployment.namespace,
        "--service", service,
        "--config", str(gate_config(deployment.robot, deployment.profile)),
        "--state-dir", str(state_dir),
    ]  # fmt: skip
    for endpoint in endpoints.listen:
        command += ["--listen", endpoint]
    for endpoint in endpoints.connect:
        command += ["--router" if endpoints.mode == "client" else "--connect", endpoint]
    if endpoints.access:
        file = write_session(deployment.keys, service, endpoints.part)
        command += ["--access", str(file)]
    return command


def service_environment() -> dict[str, str]:
    """The caller's environment, unbuffered, with one thread per numeric library and two heaps.

    Four services share the host's cores; a numeric library that starts a thread per core
    in each of them would make them wait for each other. And glibc gives each of Zenoh's threads a
    heap of its own, all of which grow in turn to what one needs: over 100,000 ticks the runner
    grew by 3.5 % so, with two by 1.9 % (``python -m bench.faults --row 40``).
    """
    environment = dict(os.environ)
    environment["PYTHONUNBUFFERED"] = "1"
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        environment.setdefault(variable, "1")
    environment.setdefault("MALLOC_ARENA_MAX", "2")
    return environment
