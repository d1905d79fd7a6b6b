"""A deployment of one's own: an id nobody uses, a state folder made anew.

The demo, ``parity`` and the tests run on copies made here, so they meet neither a
running deployment nor what an earlier run left behind.
"""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any, Literal

import yaml

from fairlead.deploy.credentials import forget_secrets
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.registry import Registry
from fairlead.deploy.sockets import forget_sockets
from fairlead.errors import ConfigError, FairleadError, ServiceError, expected
from fairlead.operate.blocking import LoopThread
from fairlead.operate.client import RobotClient
from fairlead_tools.supervisor import Supervisor
from fairlead_tools.supervisor.command_line import CommandBuilder, service_command
from fairlead_tools.supervisor.this_host import free_ports

_FILE = "deployment.yaml"
_NUMBERS = count(1)


@dataclass(frozen=True)
class Scratch:
    """A deployment file in its own fresh folder."""

    file: Path
    deployment: Deployment
    state_dir: Path


@dataclass(frozen=True)
class ScratchOptions:
    """What differs from the copied file.

    hal: runs in the place of the file's HAL: a service's spec without ``listen``.
    options: by service name, merged over the service's own options.
    localiser: who sends ``map -> odom``; "" for the HAL, whatever the file says.
    access: as in a deployment file, whatever the copied one says.
    ports: where access is open, services listen on ports, not on sockets.
    """

    id: str = ""
    pacing: Literal["realtime", "lockstep"] | None = None
    hal: dict[str, Any] | None = None
    options: dict[str, dict[str, Any]] = field(default_factory=dict)
    localiser: str = ""
    access: Literal["closed", "open"] = "closed"
    ports: bool = False


def make_scratch(source: Path, folder: Path, options: ScratchOptions) -> Scratch:
    """Copy ``source`` into ``folder`` (emptied first) as a simulator-only deployment.

    Raises:
        ConfigError: if the source cannot be read, the copy does not fit, or the folder
            holds what was not made here, or another run uses it.
    """
    original = load_deployment(source)
    if original.profile != "sim" and options.hal is None:  # its HAL would drive the real one
        who = f"deployment {original.id}: a copy of the robot"
        raise ConfigError(expected(who, "profile sim", original.profile))
    services = original.model_dump(mode="json")["services"]
    if options.hal is not None:
        services[original.hal] = dict(options.hal)
    ports = free_ports(len(services)) if options.ports else []
    for name, spec in services.items():
        spec.pop("listen", None)
        if ports:
            spec["listen"] = f"tcp/127.0.0.1:{ports.pop()}"
        spec["host"] = ""  # peers, all of them here
        spec["options"] = spec.get("options", {}) | options.options.get(name, {})
    copy = {
        "robot": original.robot,
        "id": options.id or f"{original.id}_{os.getpid()}_{next(_NUMBERS)}",
        "namespace": original.namespace,
        "profile": "sim",
        "pacing": options.pacing or original.pacing,
        "localiser": options.localiser,
        "access": options.access,
        "services": services,
    }
    file = folder / _FILE
    try:
        _empty(folder)
        file.write_text(yaml.safe_dump(copy, sort_keys=False), encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"state folder {folder}: cannot be made anew: {error.strerror}") from None
    return Scratch(file, load_deployment(file), folder.absolute())


def _empty(folder: Path) -> None:
    """Make ``folder`` anew, but only if an earlier run made it: it may be somebody's own."""
    if (folder / _FILE).is_file():
        with _held(folder / _FILE):
            pass
    elif folder.is_dir() and any(folder.iterdir()):
        raise ConfigError(f"state folder {folder}: holds other things; choose another --out")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)


@contextmanager
def _held(file: Path) -> Iterator[None]:
    """Have the folder of ``file`` for oneself."""
    with file.open(encoding="utf-8") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ConfigError(
                f"state folder {file.parent}: another run uses it; choose another --out"
            ) from None
        yield


READY_TIMEOUT_S = 120.0


@dataclass(frozen=True)
class ScratchRobot:
    """Running services and a client that all of them know.

    loop: where the supervisor runs; it starts nothing again unless told to, by `Supervisor.keep`.
    """

    scratch: Scratch
    loop: LoopThread
    supervisor: Supervisor
    client: RobotClient


@contextmanager
def scratch_robot(
    scratch: Scratch,
    registry: Registry | None = None,
    order: list[str] | None = None,
    command: CommandBuilder = service_command,
) -> Iterator[ScratchRobot]:
    """Start the services of ``scratch``, wait until the gate follows the HAL, stop them.

    Args:
        order: start them one by one in this order; None: all at once.
        command: builds a service's command line.

    Raises:
        ServiceError: a service died or was not ready in time, with its last lines.
        NoAnswerError: the gate does not follow the HAL.
        ConfigError: another run uses its folder.
    """
    hosts = list(scratch.deployment.hosts)
    supervisor = Supervisor(
        scratch.file,
        scratch.deployment,
        scratch.state_dir,
        registry=registry,
        command=command,
        host=hosts[0] if hosts else None,
    )
    with _held(scratch.file), closing(LoopThread()) as loop:
        try:
            loop.run(supervisor.start(order, None if order is None else READY_TIMEOUT_S))
            loop.run(supervisor.wait_ready(READY_TIMEOUT_S))
            with RobotClient(scratch.deployment) as client:
                client.wait_alive(*scratch.deployment.services, timeout_s=READY_TIMEOUT_S)
                client.wait_gate_follows()
                yield ScratchRobot(scratch, loop, supervisor, client)
        except FairleadError as error:
            story = supervisor.died()
            if story is None or (isinstance(error, ServiceError) and story in str(error)):
                raise
            raise ServiceError(f"{error}\n{story}") from None
        finally:
            loop.run(supervisor.stop())
            forget_sockets(scratch.deployment.keys)
            forget_secrets(scratch.deployment.keys)
