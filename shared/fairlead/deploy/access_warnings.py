"""What whoever starts or looks at a deployment should know of who may do what."""

from __future__ import annotations

from datetime import UTC, datetime

from fairlead.deploy.certificates import every_certificate
from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError


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
