"""The private authority of a deployment: it signs who may be whom, on which host.

Zenoh reads no list of revoked certificates. So each name of each host has a signing key of its own,
and what the router trusts is the list of these: revoked is whose signing key has left the list.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Iterable, Sequence
from datetime import datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from fairlead.deploy.certificates import (
    SUFFIX,
    TRUSTED,
    certificates_dir,
    common_name,
    has_signed,
)
from fairlead.deploy.credentials import access_dir, alone_in, check_private, write_private
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.errors import ConfigError, expected
from fairlead.paths import make_private
from fairlead.regular_file import regular

Place = tuple[str, str]
"""A host and who has a certificate there; of a person twice the name."""

SIGNING_YEARS = 20
_LEAKED = (
    "others may have copied the keys that sign: delete the folders signing and certificates beside "
    "it, then fairlead certs new, and copy to each host"
)
EARLIER = timedelta(days=1)
"""So much before it is made a certificate begins: the clocks of hosts differ."""


class Authority:
    """Makes the files that `fairlead.deploy.certificates` lists.

    Raises:
        ConfigError: the deployment has no certificates; those here were copied from elsewhere;
            others could read or write the keys that sign.
    """

    def __init__(self, deployment: Deployment) -> None:
        certified(deployment)
        self.deployment = deployment
        self.folder = certificates_dir(deployment.keys)
        self._signing = access_dir(deployment.keys) / "signing"
        if self.folder.exists() and not self._signing.exists():
            raise ConfigError(
                f"certificates in {self.folder} were copied here, the keys that signed them were "
                "not; run this where they were made"
            )
        if self._signing.exists():
            for path in (self._signing, *self._signing.iterdir()):
                check_private(path, _LEAKED)

    @property
    def router(self) -> Place:
        """The router's own."""
        return self.deployment.certified[0]

    def places(self, wanted: Sequence[str], left: bool = False) -> list[Place]:
        """Those that hosts, names, or both (``gpu/operator``) mean.

        Without words all that the deployment file names and that have one.

        Args:
            left: those that it names no more, too.

        Raises:
            ConfigError: one means none, or there are none.
        """
        every = [*self.deployment.certified, *(self.left if left else ())]
        for one in wanted:
            if not any(_means(one, place) for place in every):
                known = [*self.deployment.hosts, *("/".join(place) for place in every)]
                raise ConfigError(expected("certificates", "a host or name", one, known))
        if not wanted:
            made = [place for place in every if self._signer(place).is_file()]
            if not made:
                raise ConfigError(f"{self.folder}: no certificates; make them: fairlead certs new")
            return made
        return [place for place in every if any(_means(one, place) for one in wanted)]

    @property
    def _folders(self) -> list[str]:
        """Of each host, the router's first, and of each person."""
        return list(dict.fromkeys(one for one, _ in self.deployment.certified))

    @property
    def left(self) -> list[Place]:
        """Those with a signing key that the deployment file names no more."""
        stems = [file.stem for file in sorted(self._signing.glob(f"*{SUFFIX}"))]
        found = [(host, name) for host, _, name in (stem.partition(".") for stem in stems)]
        return [place for place in found if place not in self.deployment.certified]

    def new(self, now: datetime, days: int) -> list[Place]:
        """Make what is missing or damaged; which. What the file names no more is revoked."""
        with alone_in(self.folder.parent):
            return self._new(now, days)

    def _new(self, now: datetime, days: int) -> list[Place]:
        every = self.deployment.certified
        unsigned = [place for place in every if not self._signer(place).exists()]
        missing = [place for place in every if place in unsigned or not self._is_signed(place)]
        folders = [self.folder / one for one in self._folders]
        for folder in (self._signing, self.folder, *folders):
            make_private(folder)
        self._revoke(self.left)
        for place in unsigned:
            key, name = ec.generate_private_key(ec.SECP256R1()), f"signs {'/'.join(place)}"
            ends = now + timedelta(days=365 * SIGNING_YEARS)
            own = _builder(self._subject(place, name), key.public_key(), now, ends)
            signed = own.issuer_name(self._subject(place, name)).add_extension(
                x509.BasicConstraints(ca=True, path_length=0), critical=True
            )
            _write(self._signer(place), key, signed.sign(key, hashes.SHA256()))
        self._renew(missing, now, days)
        self._tell_whom_to_trust()
        return missing

    def renew(self, places: Iterable[Place], now: datetime, days: int) -> None:
        """Make new keys and certificates; the old ones are valid to their end.

        Raises:
            ConfigError: one was never made, or revoked, or its signing key is damaged.
        """
        with alone_in(self.folder.parent):
            self._renew(places, now, days)

    def _renew(self, places: Iterable[Place], now: datetime, days: int) -> None:
        for place in places:
            host, name = place
            if not self._signer(place).is_file():
                raise ConfigError(f"{host}/{name}: has no certificate; make it: fairlead certs new")
            signing, signer = self._read_signer(place)
            key, ends = ec.generate_private_key(ec.SECP256R1()), now + timedelta(days=days)
            subject = self._subject(place, common_name(self.deployment.keys, name))
            builder = _builder(subject, key.public_key(), now, ends)
            builder = builder.issuer_name(signer.subject)
            usage = ExtendedKeyUsageOID.CLIENT_AUTH
            if name == ROUTER:
                usage = ExtendedKeyUsageOID.SERVER_AUTH
                address = _address(self.deployment.hosts[host])
                builder = builder.add_extension(x509.SubjectAlternativeName([address]), False)
            builder = builder.add_extension(x509.ExtendedKeyUsage([usage]), critical=True)
            _write(self._file(place), key, builder.sign(signing, hashes.SHA256()))

    def revoke(self, places: Iterable[Place]) -> None:
        """Forget their signing keys, and have nobody trust what these signed.

        Raises:
            ConfigError: the signing key of another one is damaged; nobody is revoked then.
        """
        with alone_in(self.folder.parent):
            self._revoke(list(places))

    def _revoke(self, revoked: Sequence[Place]) -> None:
        self._tell_whom_to_trust(revoked)  # first: what comes after may fail
        for place in revoked:
            self._signer(place).unlink(missing_ok=True)
            self._file(place).unlink(missing_ok=True)

    def _tell_whom_to_trust(self, without: Sequence[Place] = ()) -> None:
        signers: dict[bool, str] = {True: "", False: ""}
        for place in self.deployment.certified:
            if place not in without and self._signer(place).is_file():
                signers[place[1] == ROUTER] += _pem(self._read_signer(place)[1])
        for one in self._folders:
            (self.folder / one).mkdir(mode=0o700, exist_ok=True)
            write_private(self.folder / one / TRUSTED["connect"], signers[True])
        write_private(self.folder / self.router[0] / TRUSTED["listen"], signers[False])

    def _read_signer(self, place: Place) -> tuple[ec.EllipticCurvePrivateKey, x509.Certificate]:
        try:
            text = self._signer(place).read_bytes()
            found = x509.load_pem_x509_certificate(text)
            signing = serialization.load_pem_private_key(text, None)
            if not isinstance(signing, ec.EllipticCurvePrivateKey):
                raise TypeError(type(signing).__name__)
        except (OSError, ValueError, TypeError, UnsupportedAlgorithm):
            name = "/".join(place)
            raise ConfigError(
                f"{self._signer(place)}: the key that signs for {name} is damaged: with "
                f"fairlead certs revoke revoke {name} too, then make it anew: fairlead certs new"
            ) from None
        return signing, found

    def _is_signed(self, place: Place) -> bool:
        """Whether its certificate is there, and its signing key's."""
        try:
            mine = x509.load_pem_x509_certificate(regular(self._file(place)).read_bytes())
        except (OSError, ValueError):
            return False
        return has_signed(self._read_signer(place)[1], mine)

    def _subject(self, place: Place, name: str) -> x509.Name:
        keys = self.deployment.keys
        parts = {
            NameOID.ORGANIZATION_NAME: f"{keys.namespace}/{keys.robot}",
            NameOID.ORGANIZATIONAL_UNIT_NAME: place[0],
            NameOID.COMMON_NAME: name,
        }
        return x509.Name([x509.NameAttribute(oid, value) for oid, value in parts.items()])

    def _file(self, place: Place) -> Path:
        return self.folder / place[0] / f"{place[1]}{SUFFIX}"

    def _signer(self, place: Place) -> Path:
        return self._signing / f"{'.'.join(place)}{SUFFIX}"


def certified(deployment: Deployment) -> list[Place]:
    """Who has a certificate, the router first.

    Raises:
        ConfigError: nobody.
    """
    if not deployment.certified:
        raise ConfigError(
            f"deployment {deployment.id}: has no certificates: its services are on one host, or "
            "access is open; they are for hosts and a router (docs/hosts.md)"
        )
    return deployment.certified


def _means(word: str, place: Place) -> bool:
    return word in (*place, "/".join(place))


def _address(address: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(address))
    except ValueError:
        return x509.DNSName(address)


def _builder(
    subject: x509.Name, key: ec.EllipticCurvePublicKey, now: datetime, ends: datetime
) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(min(now, ends) - EARLIER)
        .not_valid_after(ends)
    )


def _write(file: Path, key: ec.EllipticCurvePrivateKey, certificate: x509.Certificate) -> None:
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    write_private(file, secret.decode() + _pem(certificate))


def _pem(certificate: x509.Certificate) -> str:
    return certificate.public_bytes(serialization.Encoding.PEM).decode()
