"""`fairlead.connect`: the way into a running robot, for ``async with`` and for ``with``."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType

from fairlead.deploy.deployment import Deployment
from fairlead.operate.client import RobotClient
from fairlead.operate.robot import Robot
from fairlead.operate.which_deployment import find_deployment
from fairlead.wire.bus import Bus


class Connection:
    """What `connect` gives: ``async with`` enters it as a `Robot`, ``with`` as a `RobotClient`."""

    _robot: Robot
    _client: RobotClient

    def __init__(self, deployment: Deployment, by: str, bus: Bus | None) -> None:
        self._deployment, self._by, self._bus = deployment, by, bus

    async def __aenter__(self) -> Robot:
        self._robot = await Robot.open(self._deployment, self._by, self._bus)
        return self._robot

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self._robot.close()

    def __enter__(self) -> RobotClient:
        self._client = RobotClient(self._deployment, self._bus, self._by)
        return self._client

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._client.close()


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
        by: who is asking, for the logs of those who answer.
        bus: an open transport, which stays open; None: a Zenoh session of its own.

    Raises:
        ConfigError: there is no such deployment, or several run.
        NoAnswerError: none was named and none runs here.
        TransportError: (when the block is entered) no session can be opened.
    """
    return Connection(find_deployment(deployment), by, bus)
