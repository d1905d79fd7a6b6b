"""``python -m tests.faults.flood DEPLOYMENT``: 10,000 chunks a second that nobody asked for."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from fairlead.deploy.deployment import load_deployment
from fairlead.messages import NO_TRACE, ActionChunk, ActionPart, pack_floats
from fairlead.modes import ControlMode
from fairlead.wire.bus import Qos
from fairlead.wire.session import ZenohBus

RATE_HZ = 10_000
BATCH_S = 0.002


def main() -> None:
    """Flood the runner's own key until killed."""
    deployment = load_deployment(Path(sys.argv[1]))
    bus = ZenohBus(deployment.tool_endpoints())
    key = deployment.keys.candidate(deployment.runners[0])
    publisher = bus.publisher(key, ActionChunk, Qos.HOT)
    part = ActionPart(
        part=0, mode=ControlMode.CARTESIAN_DELTA, frame_id="base_link",
        values=pack_floats(np.zeros((8, 6))), active=(),
    )  # fmt: skip
    chunk = ActionChunk(
        robot_hash=bytes(32), session=1, epoch=1, claim_id=1, source="runner", seq=1, goal_id=1,
        obs_tick=1, oldest_tick=1, start_tick=1, horizon=8, parts=(part,), trace=NO_TRACE,
    )  # fmt: skip
    print("ready", flush=True)
    began, sent = time.monotonic(), 0
    while True:
        due = int((time.monotonic() - began) * RATE_HZ)
        for _ in range(min(due - sent, RATE_HZ // 10)):
            publisher.put(chunk)
        sent = due
        time.sleep(BATCH_S)


if __name__ == "__main__":
    main()
