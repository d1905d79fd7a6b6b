"""A policy server that speaks openpi's wire and misbehaves as told: ``python -m ... TURN``.

Each line on its standard input is what it does from then on; each line of JSON on its standard
output says what it did, and when (CLOCK_MONOTONIC [ns]).
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time

import numpy as np
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import ServerConnection, serve

from fairlead_skill_runner.policies.remote.openpi_wire import encode

ROWS, DIM, TURN, GRIPPER = 12, 10, 8, 9
SPEED = 0.4
"""Of the base's full turning speed; a late answer turns it the other way."""
USUAL_S = 0.04
SLOWER = 10
LATE_S = 2.2
"""Longer than anybody waits."""
ANSWER_TIMEOUT_S = 1.5
LATE_ANSWER = "sends the late answer"
GOOD, SLOW, HANG, DROP, LATE, GARBAGE = "good", "slow", "hang", "drop", "late", "garbage"


class PolicyServer:
    """One behaviour at a time."""

    def __init__(self) -> None:
        self.behaviour = GOOD

    def handle(self, link: ServerConnection) -> None:
        """Greet, then answer until the policy hangs up."""
        link.send(encode({"who": "bench.faults.policy_server"}))
        try:
            while True:
                link.recv()
                if not self._answer(link, self.behaviour):
                    return
        except ConnectionClosed:
            _say("hung up")

    def _answer(self, link: ServerConnection, behaviour: str) -> bool:
        if behaviour != GOOD:
            _say(behaviour)
        if behaviour == HANG:
            threading.Event().wait()
        if behaviour == DROP:
            link.socket.close()
            return False
        waits = {SLOW: SLOWER * USUAL_S, LATE: LATE_S}
        threading.Event().wait(waits.get(behaviour, USUAL_S))
        if behaviour == LATE:
            _say(LATE_ANSWER)
        link.send(os.urandom(200) if behaviour == GARBAGE else _rows(late=behaviour == LATE))
        return True


def _rows(*, late: bool) -> bytes:
    rows = np.zeros((ROWS, DIM), np.float32)
    rows[:, TURN], rows[:, GRIPPER] = -SPEED if late else SPEED, 1.0
    return encode({"actions": rows})


def _say(what: str) -> None:
    print(json.dumps({"what": what, "at_ns": time.monotonic_ns()}), flush=True)


def main() -> int:
    """Serve until standard input ends."""
    policy = PolicyServer()
    with serve(policy.handle, "127.0.0.1", 0, compression=None, max_size=None) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        _say(f"ws://127.0.0.1:{server.socket.getsockname()[1]}")
        for line in sys.stdin:
            policy.behaviour = line.strip()
            _say(f"from now on {policy.behaviour}")
    os._exit(0)  # a call that hangs keeps no server alive


if __name__ == "__main__":
    main()
