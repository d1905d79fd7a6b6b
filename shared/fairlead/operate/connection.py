"""`fairlead.connect`: the way into a running robot, for ``async with`` and for ``with``."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.registry import Registry
from fairlead.errors import ConfigError, FairleadError, NoAnswerError, expected
from fairlead.operate.client import RobotClient
from fairlead.operate.robot import Robot
from fairlead.paths import deployment_names, deployment_path
from fairlead.wire.bus import Bus


def find_deployment(wanted: Deployment | Path | str | None) -> Deployment:
    """The deployment itself, from its file, its name, or because no other runs here.

    Args:
        wanted: a name as in ``fairlead ps``, a name in compose/, a file; None: the only
            deployment that runs on this machine.

    Raises:
        ConfigError: there is no such deployment, or several run.
        NoAnswerError: none was named and none runs.
    """
    if isinstance(wanted, Deployment):
        return wanted
    return load_deployment(choose_file(None if wanted is None else file_of(str(wanted))))


def file_of(wanted: str) -> Path:
    """The file of a deployment that runs here, by its name, or of one that is known or named.

    Raises:
        ConfigError: there is none.
    """
    running = Registry().find(wanted)
    return Path(running.deployment) if running is not None else deployment_path(wanted)


def choose_file(file: Path | None) -> Path:
    """The file of the deployment a command is about; raises as `choose_deployment` does."""
    if file is not None:
        return file
    running = running_files()
    if len(running) > 1:
        files = "\n".join(f"  --deployment {shlex.quote(str(file))}" for file in running)
        raise ConfigError(f"several deployments run on this machine; add one of:\n{files}")
    return running[0]


def running_files() -> list[Path]:
    """Files of all deployments that run here, each once even if several of its hosts do.

    Raises:
        NoAnswerError: none runs.
    """
    running = sorted({entry.deployment for entry in Registry().entries()})
    if not running:
        raise nothing_runs()
    return [Path(file) for file in running]


def nothing_runs() -> NoAnswerError:
    """What to say where no deployment was started: how, and which there are."""
    known = ", ".join(deployment_names())
    return NoAnswerError(
        "no deployment runs on this machine; start one: fairlead up NAME "
        f"(valid: {known or 'none'}, or a file), or name one that runs elsewhere: "
        "--deployment FILE"
    )


class _NoBlockError(ConfigError, AttributeError):
    """So that `hasattr` and debuggers get the answer that they know."""


class Connection:
    """What `connect` gives: ``async with`` enters it as a `Robot`, ``with`` as a `RobotClient`."""

    def __init__(self, deployment: Deployment, by: str, bus: Bus | None) -> None:
        self._deployment, self._by, self._bus = deployment, by, bus
        self._robots: list[Robot] = []
        self._clients: list[RobotClient] = []

    def __getattr__(self, name: str) -> NoReturn:
        if name.startswith("_"):
            raise AttributeError(name)
        what = "`with connect(...) as robot` (or `async with`), and then robot."
        raise _NoBlockError(expected("connect", what + name, f"{name} without the block"))

    async def __aenter__(self) -> Robot:
        self._robots.append(await Robot.open(self._deployment, self._by, self._bus))
        return self._robots[-1]

    async def __aexit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        with _noted(error):
            await self._robots.pop().close()

    def __enter__(self) -> RobotClient:
        self._clients.append(RobotClient(self._deployment, self._bus, self._by))
        return self._clients[-1]

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        with _noted(error):
            self._clients.pop().close()


@contextmanager
def _noted(error: BaseException | None) -> Iterator[None]:
    """What goes wrong at the end of a block does not hide the error that ended it."""
    try:
        yield
    except FairleadError as ending:
        if error is None:
            raise
        error.add_note(f"and at the end of the robot's block: {ending}")


def connect(
    deployment: Deployment | Path | str | None = None,
    *,
    by: str = "a fairlead client",
    bus: Bus | None = None,
) -> Connection:
    """Join a running robot.

    Args:
        deployment: a name as in ``fairlead ps``, a name in compose/, a file; None: the only
            deployment that runs on this machine.
        by: the program that asks; services log it behind the person's name.
        bus: an open transport, which stays open; None: a Zenoh session of its own.

    Raises:
        ConfigError: there is no such deployment, or several run.
        NoAnswerError: none was named and none runs here.
        TransportError: (when the block is entered) no session can be opened.
    """
    return Connection(find_deployment(deployment), by, bus)
