"""Questions to Linux about processes and ports, answered from ``/proc``."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass
from ipaddress import IPv4Address, IPv6Address, ip_address
from pathlib import Path

Place = tuple[str, int]
"""An address of this host and a TCP port."""

_LISTEN = "0A"  # TCP_LISTEN in /proc/net/tcp
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


def is_listening(port: int) -> bool:
    """Whether any process on this host listens on a TCP port."""
    return any(one.port == port for one in _listeners())


def is_trusted_at(places: Collection[Place]) -> dict[Place, bool]:
    """Of TCP places of this host, those where somebody listens: whether root or this user does.

    Whoever listens at the address itself is reached before who listens at every address.
    """
    listeners, found = list(_listeners()), {}
    for address, port in places:
        at = [one for one in listeners if one.port == port]
        exact = [one for one in at if one.address in _addresses(address)]
        users = {one.user for one in exact or (one for one in at if one.address.is_unspecified)}
        if users:
            found[address, port] = users <= {0, os.geteuid()}
    return found


def listener_of(port: int) -> int | None:
    """Who listens on a TCP port; None if nobody does or the owner is another user."""
    wanted = {f"socket:[{one.inode}]" for one in _listeners() if one.port == port}
    if not wanted:
        return None
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and wanted & _open_files(entry):
            return int(entry.name)
    return None


@dataclass(frozen=True)
class _Listener:
    address: IPv4Address | IPv6Address
    port: int
    user: int
    inode: str


def _listeners() -> Iterator[_Listener]:
    """Each socket that listens."""
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        with suppress(OSError), Path(table).open(encoding="ascii") as rows:  # or without IPv6
            for row in rows:
                fields = row.split()
                if fields[3] == _LISTEN:
                    address, port = fields[1].split(":")
                    yield _Listener(_address(address), int(port, 16), int(fields[7]), fields[9])


def _address(words: str) -> IPv4Address | IPv6Address:
    """From the kernel's hexadecimal words of 32 bits, each as this machine has it in memory."""
    raw = b"".join(
        int(words[at : at + 8], 16).to_bytes(4, sys.byteorder) for at in range(0, len(words), 8)
    )
    found = ip_address(raw)
    return getattr(found, "ipv4_mapped", None) or found


def _addresses(host: str) -> set[IPv4Address | IPv6Address]:
    """What a host's name stands for here; of names there is only that of this host."""
    try:
        return {ip_address(host)}
    except ValueError:
        return {ip_address("127.0.0.1"), ip_address("::1")}


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
