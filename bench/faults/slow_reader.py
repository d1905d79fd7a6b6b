"""``python -m bench.faults.slow_reader DEPLOYMENT``: subscribes to much and cannot keep up."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

from fairlead.deploy.deployment import load_deployment
from fairlead.wire.bus import Sample
from fairlead.wire.session import ZenohBus

CALLBACK_S = 0.2
FIRST_S = 10.0
_heard, _busy = threading.Event(), threading.Event()


def _take_long(sample: Sample) -> None:
    _heard.set()
    _busy.wait(CALLBACK_S)


def main() -> None:
    """Read, ever later, until killed."""
    deployment = load_deployment(Path(sys.argv[1]))
    bus, keys = ZenohBus(deployment.tool_endpoints()), deployment.keys
    for key in (keys.joints, keys.lease, keys.every_safe, keys.every_verdict):
        bus.subscribe(key, _take_long)
    if not _heard.wait(FIRST_S):
        sys.exit("slow reader: it hears nothing")
    print("ready", flush=True)
    threading.Event().wait()


if __name__ == "__main__":
    main()
