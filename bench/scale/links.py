"""Bytes and packets of a router's links, as the kernel counts them."""

from __future__ import annotations

import re
import shutil
import subprocess
import time
from collections.abc import Collection
from dataclasses import dataclass

_BYTES = re.compile(r" bytes_(?:sent|received):(\d+)")
_PACKETS = re.compile(r" data_segs_(?:in|out):(\d+)")


@dataclass(frozen=True)
class Links:
    """Both ways, of all links to a router's ports; packets are those with data."""

    stamp_ns: int
    bytes: int
    packets: int

    def a_second(self, before: Links, robots: int) -> tuple[float, float]:
        """Bytes and packets of a robot."""
        per = robots * (self.stamp_ns - before.stamp_ns) / 1e9
        return (self.bytes - before.bytes) / per, (self.packets - before.packets) / per


def counted(ports: Collection[int]) -> Links | None:
    """What passed so far; None where there is no ``ss`` (iproute2)."""
    if shutil.which("ss") is None:
        return None
    told = subprocess.run(["ss", "-tinHO"], capture_output=True, text=True, check=True).stdout
    ours = [line for line in told.splitlines() if _local_port(line) in ports]
    data, packets = (
        sum(int(number) for line in ours for number in pattern.findall(line))
        for pattern in (_BYTES, _PACKETS)
    )
    return Links(time.monotonic_ns(), data, packets)


def _local_port(line: str) -> int:
    return int(line.split()[3].rpartition(":")[2])
