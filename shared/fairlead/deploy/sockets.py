"""Where the services of one host meet: each on a socket in a folder that only this user can enter.

``sockets`` lies beside what proves their names (`fairlead.deploy.credentials`), so whoever finds
the one finds the other: in a shell, a unit or a container. The kernel takes no socket's path of
more than 107 bytes: where it is longer, a link ``/tmp/fairlead-UID/DIGEST`` names that folder, and
no service's name is too long for that.
"""

from __future__ import annotations

import hashlib
import os
import re
from contextlib import suppress
from pathlib import Path

from fairlead.deploy.credentials import access_dir, check_private
from fairlead.errors import ConfigError
from fairlead.keys import Keys
from fairlead.paths import access_variable, make_private

LONGEST_PATH = 107
"""Bytes, of a socket."""
SHORT = "/tmp/fairlead"  # noqa: S108 - it is checked

_PROTOCOL = "unixsock-stream/"
_PLAIN = re.compile(r"[^?#;\x00-\x1f\ud800-\udfff]*")  # what else is no text or ends an endpoint
_DIGITS = 10


def socket_endpoint(keys: Keys, service: str) -> str:
    """Where a service listens and its peers find it; the folder is made, and is private.

    Raises:
        ConfigError: others can enter the folder, or it cannot be made.
    """
    folder = access_dir(keys) / "sockets"
    path = folder / f"{service}.sock"  # Zenoh makes a file with .lock behind that
    try:
        make_private(folder)
        check_private(folder, "correct it, or delete it")
        if not _fits(path):
            path = _short(folder) / path.name
    except OSError as error:
        raise ConfigError(
            f"{service}: its socket: {error.filename or folder}: {error.strerror}; "
            f"{access_variable()} names another folder"
        ) from None
    return f"{_PROTOCOL}{path}"


def socket_path(endpoint: str) -> str:
    """Path of a socket's endpoint; "" of any other."""
    return endpoint.removeprefix(_PROTOCOL) if endpoint.startswith(_PROTOCOL) else ""


def forget_sockets(keys: Keys) -> None:
    """Remove the short link of a deployment that has ended for good."""
    with suppress(OSError):
        _link(access_dir(keys) / "sockets").unlink()


def _fits(path: Path) -> bool:
    is_short = len(os.fsencode(path)) <= LONGEST_PATH
    return is_short and _PLAIN.fullmatch(str(path)) is not None


def _link(folder: Path) -> Path:
    digest = hashlib.sha256(os.fsencode(folder)).hexdigest()[:_DIGITS]
    return Path(f"{SHORT}-{os.geteuid()}", digest)


def _short(folder: Path) -> Path:
    """A link to a folder, in one of /tmp that nobody else can have made or may enter."""
    link = _link(folder)
    with suppress(FileExistsError):
        link.parent.mkdir(mode=0o700)
    if link.parent.is_symlink():
        raise ConfigError(f"access: {link.parent}: expected a folder, got a link; delete it")
    check_private(link.parent, f"delete it, or {access_variable()} names a shorter folder")
    for one in link.parent.iterdir():
        if not one.exists():  # its deployment's folder was deleted
            one.unlink(missing_ok=True)
    with suppress(FileExistsError):
        link.symlink_to(folder)
    if link.readlink() != folder:
        raise ConfigError(f"access: {link}: expected a link to {folder}; delete it")
    return link
