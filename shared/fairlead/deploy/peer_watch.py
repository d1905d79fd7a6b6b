"""What a service says of those it dials that run and do not let it in."""

from __future__ import annotations

import asyncio
import logging

from fairlead.deploy.credentials import find_secrets
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.process_table import anothers_of, is_listening
from fairlead.wire.session import ZenohBus

CHECK_S = 2.0


async def watch_peers(
    bus: ZenohBus, deployment: Deployment, service: str, log: logging.Logger
) -> None:
    """Until each of those that this service dials was seen once, or said to refuse it.

    Who was started before this service was added to the file, say, has no password of it.
    """
    secrets = find_secrets(deployment.keys, deployment.parties.names)
    left, listened = set(deployment.parties.before(service)), set[str]()
    while left:
        await asyncio.sleep(CHECK_S)
        left -= {name for name in left if secrets.session_id(name) in bus.peers}
        ports = {name: int(deployment.services[name].listen.rpartition(":")[2]) for name in left}
        foreign = anothers_of(ports.values())
        here = {name for name, port in ports.items() if port not in foreign and is_listening(port)}
        for name in sorted(here & listened):
            log.warning(
                "%s runs and gives %s no link, as who was started without its password: "
                "fairlead restart %s", name, service, name,
            )  # fmt: skip
        left -= here & listened
        listened = here
