"""Certificates of a deployment on two hosts, and whom its router lets in."""

from __future__ import annotations

from datetime import UTC, datetime

from cryptography import x509

from fairlead.paths import repo_root
from fairlead_tools.certificates.authority import Authority

SOURCE = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"
NOW = datetime.now(UTC)
DAYS = 365


def trusted(authority: Authority) -> set[str]:
    """Whom the router lets in: the names of who signed for them."""
    found = x509.load_pem_x509_certificates((authority.folder / "robot/clients.ca").read_bytes())
    return {one.subject.rfc4514_string() for one in found}
