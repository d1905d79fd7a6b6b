"""Questions to Linux about processes, ports and sockets, answered from ``/proc``."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

Place = int | str
"""A TCP port, or the path of a socket."""

_LISTEN = "0A"  # TCP_LISTEN in /proc/net/tcp
_ACCEPTS = "00010000"  # in /proc/net/unix
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
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    state, *fields = stat.rpartition(")")[2].split()
    return None if state in "ZX" else ProcessId(pid, int(fields[_STARTED_FIELD - 1]))


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
    """Whether any process on this host listens there."""
    return any(one == place for one, _ in _listeners())


def listener_of(place: Place) -> int | None:
    """Who listens there; None if nobody does or the owner is another user."""
    wanted = {f"socket:[{inode}]" for one, inode in _listeners() if one == place}
    if not wanted:
        return None
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and wanted & _open_files(entry):
            return int(entry.name)
    return None


def _listeners() -> Iterator[tuple[Place, str]]:
    """Each place where somebody listens, and the number of its socket."""
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        with suppress(OSError), Path(table).open(encoding="ascii") as rows:  # or without IPv6
            for row in rows:
                fields = row.split()
                if fields[3] == _LISTEN:
                    yield int(fields[1].rpartition(":")[2], 16), fields[9]
    with suppress(OSError), Path("/proc/net/unix").open("rb") as table_of:
        for raw in table_of:
            fields = os.fsdecode(raw.rstrip(b"\n")).split(maxsplit=7)
            # Without a path there are seven; of a path with a line break a rest may stand alone.
            if len(fields) == 8 and fields[3] == _ACCEPTS:
                yield fields[7], fields[6]


def _open_files(process: Path) -> set[str]:
    names = set()
    try:
        for link in (process / "fd").iterdir():
            try:
                names.add(str(link.readlink()))
            except OSError:  # closed between the two questions
                continue
    except OSError:  # another user's process, or gone
        return set()
    return names
