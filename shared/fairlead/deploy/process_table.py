"""Questions to Linux about processes, ports and sockets.

Of a socket's path the socket itself is asked: lines of ``/proc/net/unix`` may be anybody's, for a
path may have line breaks.
"""

from __future__ import annotations

import errno
import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from fairlead.wire.socket_peer import listener_at

Place = int | str
"""A TCP port, or the path of a socket."""

_LISTEN = "0A"  # TCP_LISTEN in /proc/net/tcp
_NOBODY = (errno.ENOENT, errno.ENOTDIR, errno.ECONNREFUSED)  # none is there, or its owner is gone
_STARTED_FIELD = 19  # field 22 of /proc/PID/stat, counted after the command's bracket


@dataclass(frozen=True)
class ProcessId:
    """A process, told apart from a later one that got the same number.

    started: clock ticks after boot, as the kernel counts them.
    """

    pid: int
    started: int

    @property
    def is_running(self) -> bool:
        """Whether this very process, and no later one with its number, still runs."""
        return process_id(self.pid) == self

    @property
    def is_paused(self) -> bool:
        """Whether somebody has paused it (SIGSTOP, Ctrl-Z), so that it does nothing."""
        return (_stat(self.pid) or [""])[0] in ("T", "t")

    def send(self, number: signal.Signals) -> None:
        """Signal this very process, and none that gets its number meanwhile."""
        try:
            handle = os.pidfd_open(self.pid)
        except ProcessLookupError:
            return
        try:
            if self.is_running:
                signal.pidfd_send_signal(handle, number)
        except ProcessLookupError:  # ended between the two lines
            return
        finally:
            os.close(handle)


def process_id(pid: int) -> ProcessId | None:
    """The running process with this number; None if there is none, or only a zombie."""
    stat = _stat(pid)
    return None if stat is None or stat[0] in "ZX" else ProcessId(pid, int(stat[_STARTED_FIELD]))


def _stat(pid: int) -> list[str] | None:
    """What Linux says of a process after its command: first its state."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    return stat.rpartition(")")[2].split()


def command_of(pid: int) -> str:
    """The command line of a process, "" if it is gone."""
    try:
        raw = Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return ""
    return raw.replace(b"\0", b" ").decode(errors="replace").strip()


def group_members(group: int) -> list[int]:
    """Running processes of one process group."""
    members = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and process_id(int(entry.name)) is not None:
            try:
                if os.getpgid(int(entry.name)) == group:
                    members.append(int(entry.name))
            except ProcessLookupError:  # ended between the two questions
                continue
    return sorted(members)


def is_listening(place: Place) -> bool:
    """Whether any process on this host listens there; so too where that cannot be found out."""
    if isinstance(place, str):
        return _listener_at(place) is not None
    return any(port == place for port, _ in _listeners())


def listener_of(place: Place) -> int | None:
    """Who listens there; None if nobody does, or it cannot be found out who."""
    if isinstance(place, str):
        return _listener_at(place) or None
    wanted = {f"socket:[{inode}]" for port, inode in _listeners() if port == place}
    if not wanted:
        return None
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and wanted & _open_files(int(entry.name)):
            return int(entry.name)
    return None


def _listener_at(path: str) -> int | None:
    """The process behind a socket's path, which need not answer; 0: not to be found out."""
    if not path:
        return None
    try:
        return listener_at(path).process
    except OSError as error:
        return None if error.errno in _NOBODY else 0


def _listeners() -> Iterator[tuple[int, str]]:
    """Each TCP port where somebody listens, and the number of its socket."""
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        with suppress(OSError), Path(table).open(encoding="ascii") as rows:  # or without IPv6
            for row in rows:
                fields = row.split()
                if fields[3] == _LISTEN:
                    yield int(fields[1].rpartition(":")[2], 16), fields[9]


def _open_files(process: int) -> set[str]:
    """What a process has open; nothing of another user's, or where it is gone."""
    names = set()
    try:
        for link in Path(f"/proc/{process}/fd").iterdir():
            try:
                names.add(str(link.readlink()))
            except OSError:  # closed between the two questions
                continue
    except OSError:
        return set()
    return names
