"""What a service says of those it dials that run and do not let it in."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Collection

from fairlead.deploy.credentials import find_secrets
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.process_table import is_listening
from fairlead.deploy.sockets import socket_path
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
    while True:
        await asyncio.sleep(CHECK_S)
        left -= {name for name in left if secrets.session_id(name) in bus.peers}
        if not left:
            return
        here = await asyncio.to_thread(_listening, deployment, left)
        for name in sorted(here & listened):
            log.warning(
                "%s gives %s no link: what listens there hangs, is another program, or was started "
                "before %s was in the file; see: fairlead ps", name, service, service,
            )  # fmt: skip
        left -= here & listened
        listened = here


def _listening(deployment: Deployment, names: Collection[str]) -> set[str]:
    return {name for name in names if is_listening(socket_path(deployment.listen(name)))}
