"""Run in dora's environment: a robot's HAL, gate and feeder as nodes that only pass bytes.

``python -m bench.scale.dora_node hal|gate|feeder SIZES LOG``: messages are as large and as many as
fairlead's; nothing is computed or judged.
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

HORIZON, EXECUTE = 16, 8
"""Rows of a chunk, and ticks after which the next one comes."""

Send = Callable[[str], None]


def hal(events: Any, send: Send, log: Path) -> None:
    """Each tick its transforms and state; writes when, and when the newest lease had come."""
    lease_ns = rows = 0
    with log.open("w", buffering=1) as out:
        for event in events:
            if event["type"] != "INPUT":
                continue
            if event["id"] == "lease":
                lease_ns = time.monotonic_ns()
            elif event["id"] == "safe":
                rows = HORIZON
            elif event["id"] == "tick":
                send("tf")
                send("state")
                out.write(f"{time.monotonic_ns()} {lease_ns} {int(rows > 0)}\n")
                rows -= 1


def gate(events: Any, send: Send, _: Path) -> None:
    """A lease for each state, a verdict for each chunk, and a SafeChunk, which is sent twice."""
    again = False
    for event in events:
        if event["type"] != "INPUT":
            continue
        if event["id"] == "state":
            send("lease")
            if again:
                send("safe")
            again = False
        elif event["id"] == "chunk":
            send("verdict")
            send("safe")
            again = True


def feeder(events: Any, send: Send, _: Path) -> None:
    """A chunk each few states, and heartbeats."""
    states = 0
    for event in events:
        if event["type"] == "INPUT" and event["id"] == "state":
            if states % EXECUTE == 0:
                send("chunk")
            states += 1
        elif event["type"] == "INPUT" and event["id"] == "beat":
            send("heartbeat")


def main() -> None:
    """One node."""
    kind, sizes, log = sys.argv[1:]
    node, arrow = importlib.import_module("dora").Node(), importlib.import_module("pyarrow")
    numpy = importlib.import_module("numpy")
    messages = {
        name: arrow.array(numpy.zeros(size, dtype="u1")) for name, size in json.loads(sizes).items()
    }

    def send(name: str) -> None:
        node.send_output(name, messages[name], {})

    {"hal": hal, "gate": gate, "feeder": feeder}[kind](node, send, Path(log))


if __name__ == "__main__":
    main()
