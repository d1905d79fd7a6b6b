"""Queries that nobody waits for, and queries that nobody answers."""

from __future__ import annotations

import queue

import pytest

from fairlead.errors import FairleadError, NoAnswerError, RefusedError, TransportError
from fairlead.messages import Arm, ArmReply, Message, StatusQuery, decode
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from tests.wire.pair import DEADLINE_S, Pair


def test_a_query_that_is_taken_and_not_answered_ends_at_its_deadline(pair: Pair) -> None:
    taken: list[object] = []
    pair.near.serve_later("fl/r/cmd", "safety", lambda payload, answer: taken.append(answer))
    pair.settle()
    with pytest.raises(NoAnswerError, match=r"^fl/r/cmd: no answer within 0\.2 s; see: fairlead"):
        pair.far.query("fl/r/cmd", StatusQuery(), 0.2)
    assert len(taken) == 1


def test_who_asks_without_waiting_is_told_once_what_a_query_returns_or_raises(pair: Pair) -> None:
    def answer(payload: bytes) -> Message:
        if decode(Arm, payload).by != "me":
            raise RefusedError("safety", "not you")
        return ArmReply(epoch=1, session=2)

    pair.near.serve("fl/r/cmd", "safety", answer)
    pair.settle()
    told: queue.Queue[bytes | FairleadError] = queue.Queue()
    for who, key in (("me", "fl/r/cmd"), ("you", "fl/r/cmd"), ("me", "fl/r/nobody")):
        pair.far.ask(key, Arm(by=who), DEADLINE_S, told.put)
        reply = told.get(timeout=DEADLINE_S)
        if who == "you":
            assert isinstance(reply, RefusedError) and reply.reason == "not you"
        elif key == "fl/r/cmd":
            assert isinstance(reply, bytes) and decode(ArmReply, reply).epoch == 1
        else:
            assert isinstance(reply, NoAnswerError)
    assert told.empty()


def test_asking_on_a_session_that_has_closed_says_so() -> None:
    bus = ZenohBus(Endpoints())
    bus.close()
    with pytest.raises(TransportError, match="^fl/r/cmd: cannot ask: session closed"):
        bus.query("fl/r/cmd", StatusQuery(), DEADLINE_S)
