"""The passwords of a deployment on this machine: made once, for this user alone.

``$FAIRLEAD_ACCESS`` (default ``access`` in the user's state folder) has for each deployment

    <id>/passwords         a line ``name:password`` for each party, if there is no router
    <id>/sockets           see `fairlead.deploy.sockets`
    <id>/<service>.json    what a service that is not in Python needs for its session

and what `fairlead.deploy.certificates` lists.
"""

from __future__ import annotations

import fcntl
import json
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from fairlead.deploy.access import Secrets
from fairlead.errors import ConfigError
from fairlead.keys import Keys
from fairlead.paths import access_variable, make_private, user_access_dir, written
from fairlead.regular_file import regular

PASSWORDS = "passwords"


def find_secrets(keys: Keys, names: Sequence[str]) -> Secrets:
    """The passwords of these parties of a deployment; those that there are not yet are made.

    Raises:
        ConfigError: others could read or have written them, or they cannot be read or written.
    """
    folder = access_dir(keys)
    file = folder / PASSWORDS
    try:
        known = _read(file) if file.exists() else {}
        if known.keys() >= set(names):  # also on a disk that takes nothing any more
            check_private(folder, "correct it")
            return Secrets(known, file)
        make_private(folder)
        if not file.exists():  # whoever copies certificates to it makes it as others' folders are
            folder.chmod(0o700)
        check_private(folder, "correct it")
        with alone_in(folder):
            known = _read(file) if file.exists() else {}
            missing = [name for name in names if name not in known]
            if missing:
                known |= {name: secrets.token_hex(32) for name in missing}
                lines = "".join(f"{name}:{password}\n" for name, password in known.items())
                write_private(file, lines)
    except OSError as error:
        raise ConfigError(
            f"access: {error.filename or folder}: cannot be read or made: {error.strerror}; "
            f"{access_variable()} names another folder"
        ) from None
    return Secrets(known, file)


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Wait until no other process changes what proves names there, and keep others waiting."""
    make_private(folder)
    with os.fdopen(os.open(folder / "lock", os.O_RDONLY | os.O_CREAT, 0o600)) as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def write_session(keys: Keys, service: str, part: Mapping[str, Any]) -> Path:
    """Put what a session needs into a file that only this user can read; which."""
    file = access_dir(keys) / f"{service}.json"
    make_private(file.parent)
    write_private(file, json.dumps(dict(part)))
    return file


def forget_secrets(keys: Keys) -> None:
    """Remove what there is of a deployment that has ended for good."""
    shutil.rmtree(access_dir(keys), ignore_errors=True)


def access_dir(keys: Keys) -> Path:
    """Where passwords and certificates of a deployment are; it need not exist yet."""
    name = keys.robot if keys.namespace == "fl" else f"{keys.robot}@{keys.namespace}"
    return user_access_dir() / name


def _read(file: Path) -> dict[str, str]:
    check_private(file, _MADE_ANEW)
    lines = regular(file).read_text(encoding="utf-8", errors="replace").splitlines()
    found = dict(line.split(":", 1) for line in lines if ":" in line)
    if len(found) != len(lines) or not all(len(one) >= 32 for one in found.values()):
        raise ConfigError(
            f"access: {file}: expected lines name:password, got others; end the deployment, "
            "delete the file and start it again"
        )
    return found


def write_private(file: Path, text: str) -> None:
    """Write what only this user may read; readers see the old text or the new.

    What is there already is not written again: the disk may be full.
    """
    with suppress(OSError, UnicodeDecodeError):
        if file.stat().st_mode & 0o777 == 0o600 and regular(file).read_text("utf-8") == text:
            return
    draft = file.with_name(f".{file.name}.{os.getpid()}")
    draft.unlink(missing_ok=True)
    with written(file, draft):
        with os.fdopen(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as out:
            out.write(text)
        draft.replace(file)


_MADE_ANEW = "correct it, or delete it: it is made anew when the deployment is started again"


def check_private(path: Path, remedy: str) -> None:
    """Make sure that nobody else could have read, written or replaced a file or folder.

    Raises:
        ConfigError: somebody could; ``remedy`` says what to do.
    """
    root = user_access_dir()
    status = root.stat()
    is_others, other = status.st_uid not in (0, os.geteuid()), f"{access_variable()} names another"
    if is_others or status.st_mode & 0o022:
        mend = f"run this as uid {status.st_uid}" if is_others else "chmod go-w"
        who = f"uid {status.st_uid}" if is_others else "others"
        raise ConfigError(f"access: {root}: {who} can write there; {mend}, or {other} folder")
    status = path.stat()
    if status.st_uid != os.geteuid() or status.st_mode & 0o077:
        mode = 0o700 if path.is_dir() else 0o600
        raise ConfigError(
            f"access: {path}: expected mode {mode:o} of this user (uid {os.geteuid()}), got "
            f"{status.st_mode & 0o777:o} of uid {status.st_uid}; {remedy}"
        )
