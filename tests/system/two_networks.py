"""Two hosts on one machine: network namespaces with a link, or two loopback addresses."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

HOSTS = ("robot", "gpu")


@dataclass(frozen=True)
class TwoNetworks:
    """Addresses of the hosts ``robot`` and ``gpu``, and how to run a command on each.

    why_loopback: why there are no namespaces; "" if there are.
    """

    addresses: dict[str, str]
    why_loopback: str
    _names: dict[str, str]

    def on(self, host: str) -> list[str]:
        """The words before a command that runs on a host."""
        return [] if self.why_loopback else ["ip", "netns", "exec", self._names[host]]

    def cut(self) -> int:
        """Take the link down; nobody is told.

        Returns:
            CLOCK_MONOTONIC just before [ns].
        """
        now_ns = time.monotonic_ns()
        self._set_link("down")
        return now_ns

    def heal(self) -> int:
        """Bring the link back.

        Returns:
            CLOCK_MONOTONIC just before [ns].
        """
        now_ns = time.monotonic_ns()
        self._set_link("up")
        return now_ns

    def _set_link(self, state: str) -> None:
        _ip("-n", self._names["gpu"], "link", "set", "eth0", state)


@contextmanager
def two_networks() -> Iterator[TwoNetworks]:
    """Namespaces joined by a veth link where the machine permits it, and their end."""
    names = {host: f"fl{os.getpid()}{host}" for host in HOSTS}
    addresses = {"robot": "10.77.0.1", "gpu": "10.77.0.2"}
    try:
        try:
            _make(names, addresses)
        except (OSError, subprocess.CalledProcessError) as error:
            why = getattr(error, "stderr", "") or str(error)
            loopback = {"robot": "127.0.0.1", "gpu": "127.0.0.2"}
            network = TwoNetworks(loopback, f"no network namespaces: {why.strip()}", names)
        else:
            network = TwoNetworks(addresses, "", names)
        yield network
    finally:
        _remove(names.values())


def _make(names: dict[str, str], addresses: dict[str, str]) -> None:
    for name in names.values():
        _ip("netns", "add", name)
    one, other = (["name", "eth0", "netns", names[host]] for host in HOSTS)
    _ip("link", "add", *one, "type", "veth", "peer", *other)
    for host, name in names.items():
        _ip("-n", name, "addr", "add", f"{addresses[host]}/24", "dev", "eth0")
        for device in ("lo", "eth0"):
            _ip("-n", name, "link", "set", device, "up")


def _remove(names: Iterable[str]) -> None:
    """Both namespaces and, with them, their link."""
    for name in names:
        if Path("/run/netns", name).exists():
            _ip("netns", "del", name)


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True, timeout=20)
