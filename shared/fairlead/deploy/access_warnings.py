"""What whoever starts or looks at a deployment should know of who may do what."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Sequence
from datetime import UTC, datetime

from fairlead.deploy.certificates import every_certificate
from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError

DAY_S = 86_400.0


def access_warnings(deployment: Deployment) -> list[str]:
    """Lines: access is open, or certificates on this machine end soon or cannot be read or used."""
    if not deployment.certified:
        return [deployment.open_access] if deployment.open_access else []
    now = datetime.now(UTC)
    try:
        return [
            f"certificate of {one.host}/{one.file.stem} {text}"
            for one in every_certificate(deployment.keys)
            if (text := one.warning(deployment.keys, now))
        ]
    except ConfigError as error:  # half copied, say: no reason to end what runs
        return [str(error)]


async def warn_daily(
    deployments: Sequence[Deployment], log: logging.Logger, every_s: float = DAY_S
) -> None:
    """Log them now and each day, until cancelled: who runs for a year is started by nobody."""
    while True:
        for one in deployments:
            for text in await asyncio.to_thread(access_warnings, one):
                log.warning("%s", text)
        await asyncio.sleep(every_s)
