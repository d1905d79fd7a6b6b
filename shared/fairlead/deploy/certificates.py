"""What proves names between hosts: where certificates lie, and whether one may be used now.

``$FAIRLEAD_ACCESS`` (default ``access`` in the user's state folder) has for each deployment

    <id>/certificates/<host>/<name>.pem   of a service, tool or router: key and certificate
    <id>/certificates/<host>/router.ca    who may sign the router's: whom the others trust
    <id>/certificates/<host>/clients.ca   who may sign the others': whom the router trusts
    <id>/signing/                         the keys that sign, only where they were made
"""

from __future__ import annotations

import hashlib
import ipaddress
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fairlead.deploy.credentials import access_dir, check_private
from fairlead.deploy.hosts import ROUTER
from fairlead.errors import ConfigError
from fairlead.keys import Keys
from fairlead.paths import ACCESS_VARIABLE
from fairlead.regular_file import regular

if TYPE_CHECKING:
    from cryptography import x509

WARN_DAYS = 30
"""So long before its end a certificate is warned of."""

COMMON_NAME_MAX = 64
"""Signs; X.509's own."""

SUFFIX = ".pem"
TRUSTED = {"connect": "router.ca", "listen": "clients.ca"}
"""Files of those who may have signed the other end's certificate."""

_ENDS_A_PATH = ("?", "#", ";")
_LEAKED = "others may have read it: fairlead certs revoke, then new, where it was made"


@dataclass(frozen=True)
class Certificate:
    """A certificate and its private key.

    Attributes:
        file: both, in PEM: one file, so that it is replaced at once.
        name: whom it proves: its common name, as `common_name` says.
        addresses: at which it may be listened with it: the router's alone.
    """

    file: Path
    name: str
    begins: datetime
    ends: datetime
    addresses: Sequence[str]

    @property
    def host(self) -> str:
        """Which host it is for."""
        return self.file.parent.name

    def problem(self, keys: Keys, now: datetime) -> str:
        """Why this robot cannot use it now, and what to do; else ""."""
        if now >= self.ends:
            return f"ended {self.ends:%Y-%m-%d %H:%M} UTC; where it was made: fairlead certs renew"
        if now < self.begins:
            return f"begins {self.begins:%Y-%m-%d %H:%M} UTC; set this machine's clock"
        wanted = common_name(keys, self.file.stem)
        if self.name != wanted:
            return (
                f"is that of {self.name}, not of {wanted}; copy the folder from where it was made "
                "again; if it is the same there: fairlead certs renew"
            )
        try:
            return _trust_problem(self)
        except ConfigError as error:
            return f"is of no use: {error}"

    def warning(self, keys: Keys, now: datetime) -> str:
        """The same, or that it ends soon; else ""."""
        left = self.ends - now
        soon = left < timedelta(days=WARN_DAYS)
        ends = f"ends in {left.days} days; where it was made: fairlead certs renew" if soon else ""
        return self.problem(keys, now) or ends


def common_name(keys: Keys, name: str) -> str:
    """Of a party's certificate: ``fl/panda/hal``, as a router may serve several robots."""
    return f"{keys.namespace}/{keys.robot}/{name}"


def certificates_dir(keys: Keys) -> Path:
    """Where the folders of hosts are; it need not exist."""
    return access_dir(keys) / "certificates"


def find_certificate(keys: Keys, hosts: Sequence[str], name: str) -> Certificate:
    """The one by which a session on this machine proves its name.

    Args:
        hosts: where it may be; what is on none in particular takes the first there is.

    Raises:
        ConfigError: there is none, others could read it, or it cannot be used now.
    """
    host = certified_host(keys, hosts, name)
    file = _file(keys, host or hosts[0], name)
    if not host:
        raise ConfigError(
            f"{name}: no certificate {file}; once, on one machine: fairlead certs new FILE, "
            "and copy to each host its folder (docs/hosts.md); or put `access: open` into the "
            "deployment file: then whoever reaches the router may move the robot"
        )
    check_private(file.parent, _LEAKED)
    check_private(file, _LEAKED)
    found = read_certificate(file)
    if problem := found.problem(keys, datetime.now(UTC)):
        raise ConfigError(f"{name}: its certificate {file} {problem}")
    return found


def _trust_problem(certificate: Certificate) -> str:
    """Why the router and its clients would not believe each other, as far as it shows here."""
    own, other = TRUSTED["listen"], TRUSTED["connect"]
    if certificate.file.stem == ROUTER:
        own, other = other, own
    _trusted(certificate.file.with_name(other))
    lists = [certificate.file.with_name(own)]
    if not lists[0].is_file():  # the router's is on another host, whose folder may be here
        lists = sorted(certificate.file.parent.parent.glob(f"*/{own}"))
    if not lists:
        return ""
    from cryptography import x509

    mine = x509.load_pem_x509_certificate(certificate.file.read_bytes())
    if any(has_signed(one, mine) for file in lists for one in _trusted(file)):
        return ""
    who = "the hosts trust" if certificate.file.stem == ROUTER else "the router lets in"
    return f"is signed by nobody whom {who}; copy the folder again, or: fairlead certs new"


def has_signed(signer: x509.Certificate, other: x509.Certificate) -> bool:
    """Whether the one's key signed the other."""
    from cryptography.exceptions import InvalidSignature

    try:
        other.verify_directly_issued_by(signer)
    except (InvalidSignature, ValueError, TypeError):  # the last two: of another name or kind
        return False
    return True


def _trusted(file: Path) -> list[x509.Certificate]:
    from cryptography import x509

    try:
        return x509.load_pem_x509_certificates(regular(file).read_bytes())
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise ConfigError(
            f"certificates {file}: cannot be read: {why}; copy the folder again; if it is the "
            "same where it was made: fairlead certs new"
        ) from None


def certified_host(keys: Keys, hosts: Sequence[str], name: str) -> str:
    """The first of the hosts of which this machine has the certificate of that name; "" if none."""
    return next((host for host in hosts if _file(keys, host, name).is_file()), "")


def _file(keys: Keys, host: str, name: str) -> Path:
    return certificates_dir(keys) / host / f"{name}{SUFFIX}"


def every_certificate(keys: Keys) -> list[Certificate]:
    """All that there are on this machine, of every host.

    Raises:
        ConfigError: one cannot be read.
    """
    return [read_certificate(file) for file in sorted(certificates_dir(keys).glob(f"*/*{SUFFIX}"))]


def trusted_mark(keys: Keys, host: str, of: Literal["connect", "listen"] = "connect") -> str:
    """Of whom a host believes to be the router, or the router lets in; "" if of nobody.

    The former is the same on all hosts.
    """
    file = certificates_dir(keys) / host / TRUSTED[of]
    return hashlib.sha256(file.read_bytes()).hexdigest()[:12] if file.is_file() else ""


def read_certificate(file: Path) -> Certificate:
    """Read one from its file.

    Raises:
        ConfigError: it has none that can be read.
    """
    from cryptography import x509  # 70 ms that a robot on one host need not wait

    try:
        found = x509.load_pem_x509_certificate(regular(file).read_bytes())
        [name] = found.subject.get_attributes_for_oid(x509.NameOID.COMMON_NAME)
        extensions = found.extensions
    except (OSError, ValueError, x509.DuplicateExtension) as error:
        raise ConfigError(
            f"certificate {file}: cannot be read: {error}; copy the folder again"
        ) from None
    try:
        others = extensions.get_extension_for_class(x509.SubjectAlternativeName).value
        addresses = [str(one.value) for one in others]
    except x509.ExtensionNotFound:
        addresses = []
    return Certificate(
        file, str(name.value), found.not_valid_before_utc, found.not_valid_after_utc, addresses
    )


def transport(certificate: Certificate) -> dict[str, Any]:
    """A part of a Zenoh configuration: a client's TLS, in which both ends prove their names.

    Zenoh reads the files each time it connects.
    """
    file = str(certificate.file)
    return {
        "link": {
            "tls": {
                "root_ca_certificate": str(certificate.file.parent / TRUSTED["connect"]),
                "enable_mtls": True,
                "connect_private_key": file,
                "connect_certificate": file,
                "verify_name_on_connect": True,
                "close_link_on_expiration": True,
            }
        }
    }


def certified_endpoint(endpoint: str, certificate: Certificate) -> str:
    """A router's endpoint with its own TLS: another robot's has other certificates.

    Zenoh reads the files once.

    Raises:
        ConfigError: a path has a sign that ends it in an endpoint.
    """
    file, trusted = str(certificate.file), str(certificate.file.parent / TRUSTED["listen"])
    if any(sign in trusted for sign in _ENDS_A_PATH):
        raise ConfigError(
            f"{ROUTER}: {certificate.file}: Zenoh takes no path with {' '.join(_ENDS_A_PATH)}; "
            f"{ACCESS_VARIABLE} names another folder"
        )
    words = {
        "enable_mtls": "true",
        "close_link_on_expiration": "true",
        "root_ca_certificate_file": trusted,
        "listen_private_key_file": file,
        "listen_certificate_file": file,
    }
    return f"{endpoint}#{';'.join(f'{key}={value}' for key, value in words.items())}"


def check_address(certificate: Certificate, address: str) -> None:
    """Make sure that the router's certificate is for where it listens.

    Raises:
        ConfigError: it is for another address.
    """
    if _plain(address) not in certificate.addresses:
        raise ConfigError(
            f"{ROUTER}: its certificate {certificate.file} is for "
            f"{', '.join(certificate.addresses) or 'no address'}, and it listens on {address}; "
            "where it was made: fairlead certs renew"
        )


def _plain(address: str) -> str:
    try:
        return str(ipaddress.ip_address(address))
    except ValueError:  # a name
        return address
