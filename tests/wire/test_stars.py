"""What a subscription to a ``*`` hears, and what is left of it: each key is named once heard."""

from __future__ import annotations

import json
import queue
from contextlib import closing
from typing import Any

import zenoh

from fairlead.messages import Heartbeat, decode
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import MOST_NAMED_KEYS, ZenohBus
from tests.wire.pair import DEADLINE_S, Pair, free_endpoint


def test_what_a_star_matches_arrives_once_and_in_order_on_any_number_of_keys(
    pair: Pair,
) -> None:
    inbox = queue.Queue[Sample]()
    pair.near.subscribe("fl/r/tf/*", inbox.put)
    pair.settle()
    keys = [f"fl/r/tf/{number}" for number in range(MOST_NAMED_KEYS + 2)]
    publishers = [pair.far.publisher(key, Heartbeat, Qos.STATUS) for key in keys]
    for claim_id in range(3):
        for key, publisher in zip(keys, publishers, strict=True):
            publisher.put(Heartbeat(claim_id=claim_id))
            sample = inbox.get(timeout=DEADLINE_S)
            assert (sample.key, decode(Heartbeat, sample.payload).claim_id) == (key, claim_id)
        pair.settle()
    assert inbox.empty()


def is_wanted(publisher: zenoh.Publisher) -> bool:
    status: Any = publisher.matching_status  # its stub has a bool
    return bool(status.matching)


def test_a_star_taken_back_is_taken_back_on_each_key_that_it_heard() -> None:
    endpoint, wanted, inbox = free_endpoint(), queue.Queue[bool](), queue.Queue[Sample]()
    with closing(ZenohBus(Endpoints(listen=[endpoint]))) as near:
        stars = [near.subscribe("fl/r/*", inbox.put) for _ in range(2)]
        config = zenoh.Config.from_json5(json.dumps(Endpoints(connect=[endpoint]).config()))
        with zenoh.open(config) as far, far.declare_publisher("fl/r/x") as publisher:
            publisher.declare_matching_listener(lambda status: wanted.put(status.matching))
            while not is_wanted(publisher):
                assert wanted.get(timeout=DEADLINE_S)
            for _ in range(3):
                publisher.put(b"")
                assert [inbox.get(timeout=DEADLINE_S).key for _ in stars] == ["fl/r/x"] * 2
            for star in stars:
                star.undeclare()
            while is_wanted(publisher):
                wanted.get(timeout=DEADLINE_S)
