"""Certificates of a deployment on two hosts, and whom its router lets in."""

from __future__ import annotations

import shutil
from datetime import UTC, datetime
from pathlib import Path

from cryptography import x509

from fairlead.deploy.certificates import certificates_dir
from fairlead.deploy.deployment import Deployment
from fairlead.paths import repo_root
from fairlead_tools.certificates.authority import Authority

SOURCE = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"
NOW = datetime.now(UTC)
DAYS = 365
PEOPLE = ["ada", "ben"]


def trusted(authority: Authority) -> set[str]:
    """Whom the router lets in: the names of who signed for them."""
    found = x509.load_pem_x509_certificates((authority.folder / "robot/clients.ca").read_bytes())
    return {one.subject.rfc4514_string() for one in found}


def account(folder: Path, deployment: Deployment, *names: str) -> Path:
    """A folder of certificates as an account has it, with these of all there are."""
    made = certificates_dir(deployment.keys)
    own = folder / "-".join(names)
    for name in names:
        shutil.copytree(made / name, own / deployment.id / "certificates" / name)
    for path in own.rglob("*"):
        path.chmod(0o700 if path.is_dir() else 0o600)
    return own
