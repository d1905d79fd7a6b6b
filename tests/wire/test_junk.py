"""What others send: junk, and texts that would like to be more than texts."""

from __future__ import annotations

import queue

import pytest

from fairlead.errors import RefusedError
from fairlead.messages import Arm, Heartbeat, Message, decode
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.failures import dropping
from tests.wire.pair import DEADLINE_S, Pair


def test_a_refusal_from_afar_neither_steers_a_terminal_nor_begins_a_line(pair: Pair) -> None:
    def refuse(payload: bytes) -> Message:
        raise RefusedError("x", "two problems:\n  one\nERROR \x1b[2J\r", "do\nthis")

    pair.near.serve("fl/r/safety/cmd/arm", "safety", refuse)
    pair.settle()
    with pytest.raises(RefusedError) as caught:
        pair.far.query("fl/r/safety/cmd/arm", Arm(by="me"), DEADLINE_S)
    assert caught.value.reason == "two problems:\n  one\n  ERROR \\x1b[2J\\x0d"
    assert caught.value.fix == "do\\x0athis"


def test_messages_that_nobody_can_read_cost_their_reader_one_line_a_key(
    pair: Pair, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    heard: queue.Queue[int] = queue.Queue()
    pair.near.subscribe("fl/r/*", lambda s: heard.put(decode(Heartbeat, s.payload).claim_id))
    pair.settle()
    publisher = pair.far.publisher("fl/r/x", Heartbeat, Qos.STATUS)
    for _ in range(3):
        publisher.put_bytes(b"\xff\x1b[2Jjunk")
    publisher.put(Heartbeat(claim_id=2))
    assert heard.get(timeout=DEADLINE_S) == 2
    (record,) = caplog.records
    assert record.getMessage().startswith("fl/r/x: dropped: Heartbeat: ")
    assert "Traceback" not in capfd.readouterr().err


def test_what_cannot_be_read_is_said_again_after_an_hour(caplog: pytest.LogCaptureFixture) -> None:
    now_ns = 0
    take = dropping(lambda sample: print(decode(Heartbeat, sample.payload)), lambda: now_ns)
    for seconds, lines in ((0, 1), (3599, 1), (3600, 2), (3601, 2)):
        now_ns = seconds * 10**9
        take(Sample("fl/r/x", b"\xff"))
        assert len(caplog.records) == lines
