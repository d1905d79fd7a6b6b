"""The certificates of a deployment for tests, and beside them those that must open no door."""

from __future__ import annotations

import shutil
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from fairlead.deploy.access import OPERATOR
from fairlead.deploy.certificates import TRUSTED, read_certificate, transport
from fairlead.deploy.credentials import access_dir, forget_secrets
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.service_spec import ServiceSpec
from fairlead_tools.certificates.authority import Authority

DAYS = 1
NOBODY = "nobody"
UNKNOWN_NAME = "a certificate of no party's name"
"""The router makes a link with it, over which nothing passes; with the others there is no link."""


def make_certificates(deployment: Deployment, host: str) -> dict[str, dict[str, Any]]:
    """Make a deployment's certificates; what a stranger on a host proves its name with, by kind.

    Each is a part of a Zenoh configuration, as of an operator's session.
    """
    authority, now = Authority(deployment), datetime.now(UTC)
    folder = access_dir(deployment.keys) / "strangers"
    proofs: dict[str, dict[str, Any]] = {}

    def keep(kind: str, file: Path) -> None:
        own = folder / kind.replace(" ", "-")
        own.mkdir(parents=True)
        kept = Path(shutil.copy(file, own))
        shutil.copy(authority.folder / host / TRUSTED["connect"], own)
        proofs[kind] = {"transport": transport(read_certificate(kept))}

    operator = (host, OPERATOR)
    file = authority.folder / host / f"{OPERATOR}.pem"
    authority.new(now, DAYS)
    keep("a revoked certificate", file)
    authority.revoke([operator])
    authority.new(now, DAYS)
    authority.renew([operator], now - timedelta(days=DAYS + 1), DAYS)
    keep("an expired certificate", file)
    authority.renew([operator], now, DAYS)

    foreign = Authority(deployment.model_copy(update={"namespace": "another"}))
    foreign.new(now, DAYS)
    keep("another robot's certificate", foreign.folder / host / file.name)
    forget_secrets(foreign.deployment.keys)
    more = {**deployment.services, NOBODY: ServiceSpec(run="skill_runner", host=host)}
    named = Authority(deployment.model_copy(update={"services": more}))
    named.new(now, DAYS)
    keep(UNKNOWN_NAME, named.folder / host / f"{NOBODY}.pem")
    return proofs
