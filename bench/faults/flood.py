"""``python -m bench.faults.flood DEPLOYMENT KIND``: what nobody asked for, as much as there can be.

Prints ``ready`` once it begins, and goes on until it is killed.
"""

from __future__ import annotations

import socket
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.sockets import socket_path
from fairlead.errors import FairleadError
from fairlead.messages import (
    NO_TRACE,
    ActionChunk,
    ActionPart,
    HalStatus,
    JointState,
    Lease,
    Message,
    StatusQuery,
    TransformBatch,
    encode,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.operate.client import RobotClient
from fairlead.wire.bus import Qos

RATE_HZ = 10_000
BATCH_S = 0.002
CONNECTIONS = 1200
ASKERS = 2
"""Of each service that answers."""
JUNK = b"\xff" * 200


def _linked(deployment: Deployment) -> RobotClient:
    """A client that sees all whom a flood is for: else nobody would hear it."""
    client = RobotClient(deployment)
    client.wait_alive("hal", "safety", "runner")
    return client


def _put(deployment: Deployment, key: str, kind: type[Message], payload: bytes) -> None:
    client = _linked(deployment)
    publisher = client.bus.publisher(key, kind, Qos.HOT)
    print("ready", flush=True)
    began, sent = time.monotonic(), 0
    while True:
        due = int((time.monotonic() - began) * RATE_HZ)
        for _ in range(min(due - sent, RATE_HZ // 10)):
            publisher.put_bytes(payload)
        sent = due
        time.sleep(BATCH_S)  # the pace of the flood itself: nothing is waited for


def _candidates(deployment: Deployment) -> None:
    part = ActionPart(
        part=0, mode=ControlMode.CARTESIAN_DELTA, frame_id="base_link",
        values=pack_floats(np.zeros((8, 6))), active=(),
    )  # fmt: skip
    chunk = ActionChunk(
        robot_hash=bytes(32), session=1, epoch=1, claim_id=1, source="runner", seq=1, goal_id=1,
        obs_tick=1, oldest_tick=1, start_tick=1, horizon=8, parts=(part,), trace=NO_TRACE,
    )  # fmt: skip
    runner = deployment.runners[0]
    _put(deployment, deployment.keys.candidate(runner), ActionChunk, encode(chunk))


def _states(deployment: Deployment) -> None:
    """Well-formed, of a HAL that nobody knows."""
    block = pack_floats(np.zeros(14))
    state = JointState(
        session=1, tick=5, episode_tick=1, stamp_ns=0, positions=block, velocities=block,
        efforts=block, acted=(), robot_hash=bytes(32),
    )  # fmt: skip
    _put(deployment, deployment.keys.joints, JointState, encode(state))


def _queries(deployment: Deployment) -> None:
    """Each asks again as soon as it is answered."""
    client, keys = _linked(deployment), deployment.keys

    def ask(key: str) -> None:
        while True:
            with suppress(FairleadError):
                client.bus.query(key, StatusQuery(), 3.0)

    for key in (keys.gate_status, keys.hal_status, keys.feedback(deployment.runners[0])) * ASKERS:
        threading.Thread(target=ask, args=(key,), daemon=True).start()
    print("ready", flush=True)
    threading.Event().wait()


def _connections(deployment: Deployment) -> None:
    """As many to each service."""
    places = [socket_path(deployment.listen(one)) for one in deployment.services]
    crowd = []
    for number in range(CONNECTIONS):
        crowd.append(socket.socket(socket.AF_UNIX))
        crowd[-1].connect(places[number % len(places)])
    print("ready", flush=True)
    threading.Event().wait()


WITH_RIGHTS = ("queries", "connections")
"""What a deployment with closed access lets through; the rest needs an open one."""
FLOODS: dict[str, Callable[[Deployment], None]] = {
    "candidates": _candidates,
    "joint states": _states,
    "malformed hal/status messages": lambda d: _put(d, d.keys.hal_status, HalStatus, JUNK),
    "malformed leases": lambda d: _put(d, d.keys.lease, Lease, JUNK),
    "malformed transforms": lambda d: _put(d, d.keys.tf("stranger"), TransformBatch, JUNK),
    "queries": _queries,
    "connections": _connections,
}

if __name__ == "__main__":
    FLOODS[sys.argv[2]](load_deployment(Path(sys.argv[1])))
