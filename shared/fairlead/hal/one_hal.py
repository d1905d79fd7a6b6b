"""That a HAL is its robot's only one, and has its state folder for itself."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import logging
import os
import socket
import threading
from contextlib import ExitStack
from pathlib import Path
from typing import TextIO

from fairlead.deploy.registry import Registry
from fairlead.errors import ConfigError
from fairlead.keys import Keys, last_chunk
from fairlead.wire.bus import Bus
from fairlead.wire.socket_peer import listener_at

LOCK = "only-hal.lock"
"""Of the sockets' folder, where no service's file is called so."""
LOOK_S = 0.7
"""Longer than a Zenoh session waits between two attempts to connect (0.5 s)."""
GO_S = 4.0
"""What a HAL that started at the same moment, or died with its host, gets to be gone."""


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

    A HAL is found so even if it is paused and no link to it can form: by the name of an abstract
    Unix socket; and by a lock in the folder of its deployment's sockets, which counts alone where
    another user has taken the name. The kernel frees both when the process ends, however it ends.

    Args:
        folder: of the sockets, which only this user can enter; None: there is none, and the name
            must be had.

    Raises:
        ConfigError: naming the process that holds it, or why nobody can.
    """
    who = f"{os.getuid()}/{keys.namespace}/{keys.robot}"
    name = f"fairlead-hal/{hashlib.sha256(who.encode()).hexdigest()}"
    with ExitStack() as held:
        is_locked = folder is not None and _lock(service, keys, folder / LOCK, held)
        if not _take_name(service, keys, name, held):
            try:
                process, user = listener_at(f"\0{name}")
            except OSError as error:
                # A HAL listens. One that so many have asked already says no more who it is.
                if not is_locked or not isinstance(error, ConnectionRefusedError):
                    raise _second_hal(service, keys, "process unknown") from None
                other = "a process that does not listen"
            else:
                if user == os.getuid():
                    raise _second_hal(service, keys, f"process {process}", process)
                other = f"process {process} of another user (uid {user})"
                if not is_locked:
                    raise ConfigError(
                        f"{service}: robot {keys.robot} cannot be held for this process: {other} "
                        "has taken its name; ask its owner, or give this robot another `id`"
                    )
            logging.getLogger(service).warning("%s has taken the name of this HAL", other)
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
        found = file.read() or "unknown"
        process = int(found) if found.isdecimal() else None
        raise _second_hal(service, keys, f"process {found}", process) from None
    file.truncate(0)
    file.write(str(os.getpid()))
    file.flush()
    return True


def _take_name(service: str, keys: Keys, name: str, held: ExitStack) -> bool:
    """Listen behind an abstract socket's name; False if somebody does already."""
    own = held.enter_context(socket.socket(socket.AF_UNIX))
    try:
        own.bind(f"\0{name}")
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            return False
        raise ConfigError(
            f"{service}: robot {keys.robot} cannot be held for this process: {error}"
        ) from None
    own.listen()
    return True


def _second_hal(service: str, keys: Keys, other: str, process: int | None = None) -> ConfigError:
    """process: of the other HAL, which is this user's; None: it is not known."""
    registry, another = Registry(), "give this robot another `id:` in a copy of the file"
    listed = [one.pid for entry in registry.entries() for one in entry.leftovers]
    if process is None:
        fix = "see: fairlead ps, then: fairlead down; one that fairlead ps does not list is of "
        fix += f"another user, host or state folder: end it there, or {another}"
    elif process in listed:
        fix = "see: fairlead ps, then: fairlead down"
    else:
        other += f" of this user (uid {os.getuid()})"
        fix = f"fairlead ps does not list it, for its state folder is not {registry.root}: end it "
        fix += f"where it was started (fairlead down with its FAIRLEAD_STATE), or {another}"
    return ConfigError(
        f"{service}: robot {keys.robot} already has a HAL ({other}, which may still start or be "
        f"paused); {fix}"
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
