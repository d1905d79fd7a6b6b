"""Connections that say nothing: a port that anybody may call is not made deaf by them."""

from __future__ import annotations

import queue
import socket
import threading
from contextlib import ExitStack, closing

from fairlead.messages import Heartbeat, decode
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from tests.wire.pair import DEADLINE_S, Pair, free_endpoint

CROWD = 1000
MESSAGES, PERIOD_S = 20, 0.05


def test_a_crowd_that_says_nothing_keeps_no_message_from_a_link_that_stands() -> None:
    """Before, it took all of them for longer than this goes on."""
    dialled, own = free_endpoint(), free_endpoint()
    host, _, port = own.removeprefix("tcp/").rpartition(":")
    with (
        closing(ZenohBus(Endpoints(listen=[dialled]))) as far,
        closing(ZenohBus(Endpoints(listen=[own], connect=[dialled]))) as near,
        ExitStack() as crowd,
    ):
        heard: queue.Queue[int] = queue.Queue()
        near.subscribe("fl/r/x", lambda s: heard.put(decode(Heartbeat, s.payload).claim_id))
        pair = Pair(near, far)
        pair.settle()
        publisher = far.publisher("fl/r/x", Heartbeat, Qos.HOT)
        for _ in range(CROWD):
            one = crowd.enter_context(socket.socket())
            one.setblocking(False)
            one.connect_ex((host, int(port)))
        pause = threading.Event()
        for number in range(MESSAGES):
            publisher.put(Heartbeat(claim_id=number))
            pause.wait(PERIOD_S)
        in_time = heard.qsize()
        arrived = [heard.get(timeout=DEADLINE_S) for _ in range(MESSAGES)]
    assert arrived == list(range(MESSAGES))
    assert in_time > MESSAGES // 2  # when the last was sent; none were, a crowd like this before
