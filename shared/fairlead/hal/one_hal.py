"""That a HAL is its robot's only one, and has its state folder for itself."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import logging
import os
import socket
import struct
import threading
from contextlib import ExitStack
from pathlib import Path
from typing import TextIO

from fairlead.deploy.credentials import access_dir
from fairlead.deploy.process_table import open_files, own_processes
from fairlead.errors import ConfigError
from fairlead.keys import Keys, last_chunk
from fairlead.wire.bus import Bus

LOCK = "only-hal.lock"
"""Of the sockets' folder, where no service's file is called so."""
LOOK_S = 0.7
"""Longer than a Zenoh session waits between two attempts to connect (0.5 s)."""
GO_S = 4.0
"""What a HAL that started at the same moment, or died with its host, gets to be gone."""
_PEER = struct.Struct("3i")  # process, user, group


def lock_state_folder(service: str, folder: Path) -> TextIO:
    """Hold a folder for this process; the lock ends with the process, however it ends.

    Raises:
        ConfigError: if another process holds it.
    """
    path = folder / "hal.lock"
    file = path.open("a")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise ConfigError(
            f"{service}: another HAL still uses {folder}; see: fairlead ps, then: fairlead down"
        ) from None
    return file


def hold_robot(service: str, keys: Keys, folder: Path | None = None) -> ExitStack:
    """Hold a robot's id for this process, among this user's processes on this host, until closed.

    A HAL is found so even if it is paused and no link to it can form. It has the name of an
    abstract Unix socket, and a lock in the folder of its deployment's sockets, of which the name
    may be kept from it by another user: in whatever folder another HAL of this user has such a
    lock, it is seen among this user's processes. The kernel frees all of it when the process ends,
    however it ends.

    Args:
        folder: of the sockets, which only this user can enter; None: there is none.

    Raises:
        ConfigError: naming the process that holds it, or why nobody can.
    """
    with ExitStack() as held:
        is_locked = folder is not None and _lock(service, keys, folder / LOCK, held)
        other_user = _take_name(service, keys, held)
        if other_user and not is_locked:
            raise ConfigError(
                f"{service}: robot {keys.robot} cannot be held for this process: {other_user} has "
                "taken its name; ask its owner, or give this robot another `id`"
            )
        if other_user:
            logging.getLogger(service).warning("%s has taken the name of this HAL", other_user)
        if (other := _locked_elsewhere(access_dir(keys).name, folder)) is not None:
            raise _second_hal(service, keys, f"process {other}")
        return held.pop_all()


def _lock(service: str, keys: Keys, path: Path, held: ExitStack) -> bool:
    """Have a file for this process; False where none can be written."""
    try:
        file = held.enter_context(path.open("a+"))
    except OSError:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.seek(0)
        raise _second_hal(service, keys, f"process {file.read() or 'unknown'}") from None
    file.truncate(0)
    file.write(str(os.getpid()))
    file.flush()
    return True


def _take_name(service: str, keys: Keys, held: ExitStack) -> str:
    """Take the socket's name; if another user has it, who that is."""
    who = f"{os.getuid()}/{keys.namespace}/{keys.robot}"
    name = f"\0fairlead-hal/{hashlib.sha256(who.encode()).hexdigest()}"
    own = held.enter_context(socket.socket(socket.AF_UNIX))
    try:
        own.bind(name)
    except OSError as error:
        if error.errno != errno.EADDRINUSE:
            raise ConfigError(
                f"{service}: robot {keys.robot} cannot be held for this process: {error}"
            ) from None
        process, user = _holder(name)
        if user == os.getuid():
            raise _second_hal(service, keys, f"process {process}") from None
        return f"process {process} of another user (uid {user})"
    own.listen()
    return ""


def _holder(name: str) -> tuple[str, int]:
    """Process and user who listen behind a Unix socket's name; they need not answer."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as asking:
        asking.setblocking(False)
        try:
            asking.connect(name)
        except OSError:  # it has just ended, or just begun
            return "unknown", os.getuid()
        found = asking.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _PEER.size)
        process, user, _ = _PEER.unpack(found)
        return str(process), int(user)


def _locked_elsewhere(name: str, folder: Path | None) -> int | None:
    """This user's process that has the lock of a deployment of this name in another folder."""
    own = "" if folder is None else str(folder.resolve() / LOCK)
    for process in own_processes():
        for path in open_files(process):
            is_lock = path.removesuffix(" (deleted)").endswith(f"/{name}/sockets/{LOCK}")
            if is_lock and path != own and process != os.getpid():
                return process
    return None


def _second_hal(service: str, keys: Keys, other: str) -> ConfigError:
    return ConfigError(
        f"{service}: robot {keys.robot} already has a HAL ({other}, which may still start or be "
        "paused); see: fairlead ps, then: fairlead down"
    )


def refuse_second_hal(service: str, bus: Bus, keys: Keys, session: int) -> None:
    """Announce this HAL, then look for others of the robot that its Zenoh session can reach.

    Whether they answer does not matter: one that is busy or still starts counts. Of several that
    start together the one with the smallest session goes on, once the others have ended.

    Raises:
        ConfigError: naming the session of another HAL.
    """
    own, others, changed = keys.hal_session(session), set[str](), threading.Condition()

    def on_token(key: str, alive: bool) -> None:
        with changed:
            (others.add if alive and key != own else others.discard)(key)
            changed.notify_all()

    def comes_first() -> bool:
        return min(others, default=own) < own

    token = bus.declare_token(own)
    watch = bus.watch_tokens(keys.every_hal_session, on_token)
    with changed:
        changed.wait_for(comes_first, LOOK_S)
        changed.wait_for(lambda: not others or comes_first(), GO_S)
        found = sorted(others)
    watch.undeclare()
    if found:
        token.undeclare()
        raise _second_hal(service, keys, f"session {last_chunk(found[0])}")
