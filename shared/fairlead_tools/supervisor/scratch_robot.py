"""A whole robot for a moment: its services as processes, a client, and a clean end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from fairlead.deploy.registry import Registry
from fairlead.errors import FairleadError, ServiceError
from fairlead.operate.client import RobotClient
from fairlead_tools.supervisor import Supervisor
from fairlead_tools.supervisor.command_line import CommandBuilder, service_command
from fairlead_tools.supervisor.scratch import Scratch

READY_TIMEOUT_S = 120.0


@dataclass(frozen=True)
class ScratchRobot:
    """Running services and a client that all of them know."""

    scratch: Scratch
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
    try:
        supervisor.start(order, None if order is None else READY_TIMEOUT_S)
        supervisor.wait_ready(READY_TIMEOUT_S)
        with RobotClient(scratch.deployment) as client:
            client.wait_alive(*scratch.deployment.services, timeout_s=READY_TIMEOUT_S)
            client.wait_gate_follows()
            yield ScratchRobot(scratch, supervisor, client)
    except FairleadError as error:
        story = supervisor.died()
        if story is None or (isinstance(error, ServiceError) and story in str(error)):
            raise
        raise ServiceError(f"{error}\n{story}") from None
    finally:
        supervisor.stop()
