"""Queries whose answer takes its time, over the network."""

from __future__ import annotations

import os
import threading

from fairlead.messages import Arm, ArmReply, decode
from fairlead.wire.bus import Answer
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from tests.wire.pair import DEADLINE_S, Pair, free_endpoint


def test_a_query_answered_later_holds_up_no_other_on_its_key() -> None:
    endpoint = free_endpoint()
    near = ZenohBus(Endpoints(listen=[endpoint]))
    far = ZenohBus(Endpoints(connect=[endpoint]))
    Pair(near, far).settle()
    first: list[Answer] = []

    def handler(payload: bytes, answer: Answer) -> None:
        if not first:
            first.append(answer)
            return
        answer(ArmReply(epoch=2, session=2))
        first[0](ArmReply(epoch=1, session=1))

    near.serve_later("fl/r/cmd", "hal", handler)
    Pair(near, far).settle()
    replies: list[bytes] = []
    waiting = threading.Thread(
        target=lambda: replies.append(far.query("fl/r/cmd", Arm(by="me"), DEADLINE_S))
    )
    waiting.start()
    while not first:
        os.sched_yield()
    assert decode(ArmReply, far.query("fl/r/cmd", Arm(by="me"), DEADLINE_S)).epoch == 2
    waiting.join(DEADLINE_S)
    assert [decode(ArmReply, reply).epoch for reply in replies] == [1]
    far.close()
    near.close()
