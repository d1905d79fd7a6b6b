"""The deployments that run on this machine, and those that `fairlead up` has begun to start."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.registry import Registry, Running
from fairlead.errors import ConfigError
from fairlead.operate.client import RobotClient

START_TIMEOUT_S = 120.0  # as long as `fairlead up` itself waits
LOOK_AGAIN_S = 0.2


def wait_started(
    file: Path,
    say: Callable[[str], None],
    registry: Registry | None = None,
    timeout_s: float = START_TIMEOUT_S,
) -> None:
    """Return once no supervisor here is on its first start of this deployment's services.

    It does not say that they run: whoever asks them next finds out. A service that died and is
    started again is not waited for.

    Args:
        say: gets one line each time that other services are waited for.
    """
    registry = registry or Registry()
    deadline = time.monotonic() + timeout_s
    said = ""
    while (names := starting_services(file, registry)) and time.monotonic() < deadline:
        line = f"waiting for {', '.join(names)} to start"
        if line != said:
            said = line
            say(line)
        time.sleep(LOOK_AGAIN_S)


def entries_of(file: Path, registry: Registry | None = None) -> list[Running]:
    """What runs here of a deployment: one entry for each of its hosts that this machine is."""
    entries = (registry or Registry()).entries()
    return [entry for entry in entries if Path(entry.deployment).resolve() == file.resolve()]


def starting_services(file: Path, registry: Registry | None = None) -> list[str]:
    """Names of a deployment's services that are on their first start on this machine."""
    return [
        name
        for entry in entries_of(file, registry)
        if entry.is_supervised
        for name, service in entry.services.items()
        if not service.ready and service.restarts == 0 and service.running and not service.by_hand
    ]


def wait_seen(client: RobotClient, file: Path, registry: Registry | None = None) -> None:
    """Wait until every service is seen: longer for those that somebody started here by hand.

    Raises:
        NoAnswerError: naming those that are missing.
    """
    by_hand = {name for entry in entries_of(file, registry) for name in entry.by_hand}
    client.wait_alive(*by_hand, timeout_s=START_TIMEOUT_S)
    client.wait_alive(*client.deployment.services)


def running_file(robot: str) -> Path | None:
    """The deployment file of a robot that runs on this machine, if one does."""
    files = [Path(entry.deployment) for entry in Registry().entries()]
    return next((one for one in files if load_deployment(one).robot == robot), None)


def running_robot() -> str | None:
    """The robot of the only deployment that runs on this machine."""
    try:
        robots = {load_deployment(Path(one.deployment)).robot for one in Registry().entries()}
    except ConfigError:  # its file has changed or gone since
        return None
    return robots.pop() if len(robots) == 1 else None
