"""The contract of `fairlead.wire.bus.Bus`, held by the network and by the in-memory transport."""

from __future__ import annotations

import queue
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from fairlead.errors import ConfigError, NoAnswerError, RefusedError, TransportError
from fairlead.messages import (
    Arm,
    ArmReply,
    Heartbeat,
    Message,
    Refusal,
    StatusQuery,
    decode,
    encode,
)
from fairlead.wire.bus import Bus, Qos, Sample
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.memory_bus import MemoryBus, matches
from fairlead.wire.session import ZenohBus
from tests.wire.pair import DEADLINE_S, Pair, free_endpoint


@pytest.fixture
def inbox() -> queue.Queue[Sample]:
    return queue.Queue()


def drain(inbox: queue.Queue[Sample], count: int) -> list[tuple[str, int]]:
    """Key and claim id of the next ``count`` heartbeats received."""
    samples = [inbox.get(timeout=DEADLINE_S) for _ in range(count)]
    return [(s.key, decode(Heartbeat, s.payload).claim_id) for s in samples]


def beat(bus: Bus, key: str) -> Callable[[int], None]:
    """A function that publishes one heartbeat with the given claim id on ``key``."""
    publisher = bus.publisher(key, Heartbeat, Qos.STATUS)
    return lambda claim_id: publisher.put(Heartbeat(claim_id=claim_id))


def test_a_put_arrives_with_its_key_and_its_bytes(pair: Pair, inbox: queue.Queue[Sample]) -> None:
    pair.near.subscribe("fl/r/skill/a/heartbeat", inbox.put)
    pair.settle()
    pair.far.publisher("fl/r/skill/a/heartbeat", Heartbeat, Qos.HOT).put_bytes(b"\x01\x02")
    assert inbox.get(timeout=DEADLINE_S) == Sample("fl/r/skill/a/heartbeat", b"\x01\x02")


def test_a_message_and_its_encoded_bytes_arrive_alike(
    pair: Pair, inbox: queue.Queue[Sample]
) -> None:
    pair.near.subscribe("fl/r/x", inbox.put)
    pair.settle()
    publisher = pair.far.publisher("fl/r/x", Heartbeat, Qos.STATUS)
    publisher.put(Heartbeat(claim_id=5))
    publisher.put_bytes(encode(Heartbeat(claim_id=5)))
    assert inbox.get(timeout=DEADLINE_S) == inbox.get(timeout=DEADLINE_S)


def test_puts_on_one_key_arrive_in_order(pair: Pair, inbox: queue.Queue[Sample]) -> None:
    pair.near.subscribe("fl/r/x", inbox.put)
    pair.settle()
    put = beat(pair.far, "fl/r/x")
    for claim_id in range(50):
        put(claim_id)
    assert drain(inbox, 50) == [("fl/r/x", claim_id) for claim_id in range(50)]


def test_a_star_takes_exactly_one_chunk(pair: Pair, inbox: queue.Queue[Sample]) -> None:
    pair.near.subscribe("fl/r/tf/*", inbox.put)
    pair.settle()
    for claim_id, key in enumerate(
        ["fl/r/tf", "fl/r/tf/a/b", "fl/q/tf/a", "fl/r/tf/a", "fl/r/tf/b"]
    ):
        beat(pair.far, key)(claim_id)
    assert drain(inbox, 2) == [("fl/r/tf/a", 3), ("fl/r/tf/b", 4)]
    assert inbox.empty()


def test_a_put_reaches_every_subscriber_its_own_sessions_too(
    pair: Pair, inbox: queue.Queue[Sample]
) -> None:
    second: queue.Queue[Sample] = queue.Queue()
    pair.near.subscribe("fl/r/x", inbox.put)
    pair.far.subscribe("fl/r/x", second.put)
    pair.settle()
    beat(pair.far, "fl/r/x")(7)
    assert drain(inbox, 1) == drain(second, 1) == [("fl/r/x", 7)]


@pytest.mark.parametrize("heard", ["fl/r/x", "fl/r/*"])
def test_an_undeclared_subscriber_hears_nothing_more(
    pair: Pair, inbox: queue.Queue[Sample], heard: str
) -> None:
    other: queue.Queue[Sample] = queue.Queue()
    first = pair.near.subscribe(heard, inbox.put)
    pair.near.subscribe("fl/r/x", other.put)
    pair.settle()
    put = beat(pair.far, "fl/r/x")
    put(1)
    assert drain(inbox, 1) == drain(other, 1)
    first.undeclare()
    put(2)
    assert drain(other, 1) == [("fl/r/x", 2)]
    assert inbox.empty()


def test_a_query_carries_the_request_and_brings_the_reply(pair: Pair) -> None:
    def answer(payload: bytes) -> Message:
        assert decode(Arm, payload) == Arm(by="me")
        return ArmReply(epoch=1, session=2)

    pair.near.serve("fl/r/safety/cmd/arm", "safety", answer)
    pair.settle()
    reply = pair.far.query("fl/r/safety/cmd/arm", Arm(by="me"), DEADLINE_S)
    assert decode(ArmReply, reply) == ArmReply(epoch=1, session=2)


def test_a_refusal_names_who_why_and_the_fix(pair: Pair) -> None:
    def refuse(payload: bytes) -> Message:
        raise RefusedError("ignored", "arm: stopped by operator", "fairlead reset 0x7")

    pair.near.serve("fl/r/cmd", "safety", refuse)
    pair.settle()
    with pytest.raises(RefusedError) as caught:
        pair.far.query("fl/r/cmd", Arm(by="me"), DEADLINE_S)
    assert (caught.value.who, caught.value.reason) == ("safety", "arm: stopped by operator")
    assert caught.value.fix == "fairlead reset 0x7"
    assert str(caught.value) == (
        "safety refused: arm: stopped by operator\n  try: fairlead reset 0x7"
    )


def test_any_deliberate_error_of_the_server_is_a_refusal(pair: Pair) -> None:
    def refuse(payload: bytes) -> Message:
        raise ConfigError("seed: expected 0 or more, got -1")

    pair.near.serve("fl/r/cmd", "hal", refuse)
    pair.settle()
    with pytest.raises(RefusedError, match="^hal refused: seed: expected 0 or more, got -1$"):
        pair.far.query("fl/r/cmd", Arm(by="me"), DEADLINE_S)


def test_a_bug_in_a_handler_is_answered_and_logged(
    pair: Pair, caplog: pytest.LogCaptureFixture
) -> None:
    def stumble(payload: bytes) -> Message:
        raise KeyError("base")

    pair.near.serve("fl/r/cmd", "hal", stumble)
    pair.settle()
    with pytest.raises(RefusedError) as caught:
        pair.far.query("fl/r/cmd", Arm(by="me"), DEADLINE_S)
    assert str(caught.value) == (
        "hal refused: internal error, KeyError: 'base'\n  try: fairlead logs hal"
    )
    assert "in stumble" in caplog.text


def test_a_query_that_nobody_serves_gets_no_answer(pair: Pair) -> None:
    served = pair.near.serve("fl/r/cmd", "hal", lambda payload: Refusal(who="", reason="", fix=""))
    pair.settle()
    pair.far.query("fl/r/cmd", StatusQuery(), DEADLINE_S)
    served.undeclare()
    pair.settle()
    told = r"^fl/r/cmd: nobody there answers; see: fairlead ps$"
    with pytest.raises(NoAnswerError, match=told):  # at once
        pair.far.query("fl/r/cmd", StatusQuery(), DEADLINE_S)


@dataclass
class Tokens:
    """Collects liveliness changes."""

    seen: queue.Queue[tuple[str, bool]]

    def next(self) -> tuple[str, bool]:
        return self.seen.get(timeout=DEADLINE_S)


def watch(bus: Bus, key_expr: str) -> Tokens:
    tokens = Tokens(queue.Queue())
    bus.watch_tokens(key_expr, lambda key, alive: tokens.seen.put((key, alive)))
    return tokens


def test_a_late_watcher_hears_of_a_token_that_is_alive(pair: Pair) -> None:
    pair.near.declare_token("fl/r/alive/hal")
    pair.near.declare_token("fl/q/alive/hal")
    pair.settle()
    tokens = watch(pair.far, "fl/r/alive/*")
    assert tokens.next() == ("fl/r/alive/hal", True)
    pair.near.declare_token("fl/r/alive/safety")
    assert tokens.next() == ("fl/r/alive/safety", True)


def test_a_watcher_hears_when_a_token_goes(pair: Pair) -> None:
    tokens = watch(pair.far, "fl/r/alive/*")
    token = pair.near.declare_token("fl/r/alive/hal")
    assert tokens.next() == ("fl/r/alive/hal", True)
    token.undeclare()
    assert tokens.next() == ("fl/r/alive/hal", False)


def test_closing_a_bus_takes_its_tokens_with_it(pair: Pair) -> None:
    tokens = watch(pair.far, "fl/r/alive/*")
    pair.near.declare_token("fl/r/alive/hal")
    assert tokens.next() == ("fl/r/alive/hal", True)
    pair.near.close()
    assert tokens.next() == ("fl/r/alive/hal", False)


def test_a_busy_port_is_a_transport_error_that_names_it() -> None:
    endpoint = free_endpoint()
    first = ZenohBus(Endpoints(listen=[endpoint]))
    with pytest.raises(TransportError) as caught:
        ZenohBus(Endpoints(listen=[endpoint]))
    assert endpoint in str(caught.value)
    assert "see which: fairlead ps" in str(caught.value)
    first.close()


def test_sessions_meet_in_either_start_order() -> None:
    endpoint = free_endpoint()
    far = ZenohBus(Endpoints(connect=[endpoint]))
    tokens = watch(far, "fl/r/alive/*")
    near = ZenohBus(Endpoints(listen=[endpoint]))
    near.declare_token("fl/r/alive/hal")
    assert tokens.next() == ("fl/r/alive/hal", True)
    far.close()
    near.close()


def test_the_memory_bus_delivers_what_its_filter_returns(inbox: queue.Queue[Sample]) -> None:
    held: list[Sample] = []

    def late_and_twice(sample: Sample) -> list[Sample]:
        held.append(sample)
        return [held.pop(0)] * 2 if len(held) > 1 else []

    bus = MemoryBus(filter=late_and_twice)
    bus.subscribe("fl/r/x", inbox.put)
    put = beat(bus, "fl/r/x")
    put(1)
    assert inbox.empty()
    put(2)
    assert drain(inbox, 2) == [("fl/r/x", 1), ("fl/r/x", 1)]


@pytest.mark.parametrize(
    ("key_expr", "key", "fits"),
    [
        ("a/b", "a/b", True),
        ("a/b", "a/c", False),
        ("a/*", "a/b", True),
        ("a/*", "a", False),
        ("a/*", "a/b/c", False),
        ("*/b/*", "a/b/c", True),
        ("a", "a/b", False),
    ],
)
def test_memory_bus_matching(key_expr: str, key: str, fits: bool) -> None:
    assert matches(key_expr, key) is fits
