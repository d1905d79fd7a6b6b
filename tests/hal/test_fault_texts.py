"""Whatever a driver's error says, the robot holds, the gate is told, and the stop can be reset."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.hal.inbox import GATE_READS
from fairlead.messages import StopLevel, encode
from fairlead.reason_text import MOST_LETTERS, short_text
from fairlead.wire.bus import Qos
from tests.hal.running_host import KEYS, RunningHost, move_until, wait_until

NO_UTF8 = "/dev/serial/by-id/arm\udcff"


class WordlessError(Exception):
    """An error that cannot say what it is."""

    def __str__(self) -> str:
        raise ValueError("no words")


@pytest.fixture
def running(tmp_path: Path) -> Iterator[RunningHost]:
    host = RunningHost(tmp_path)
    yield host
    host.close()


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OSError(NO_UTF8), "OSError: /dev/serial/by-id/arm\\udcff"),
        (ConfigError(NO_UTF8), "/dev/serial/by-id/arm\\udcff"),
        (RuntimeError("x" * 70_000), "RuntimeError: " + "x" * (MOST_LETTERS - 14)),
        (WordlessError(), "WordlessError: its text cannot be had: ValueError"),
    ],
)
def test_a_fault_of_any_text_stops_the_gate_and_holds_in_every_period(
    running: RunningHost, error: Exception, said: str
) -> None:
    wait_until(lambda: len(running.states) > 1)
    running.backend.read_error = error
    wait_until(lambda: running.status().detail == f"{said} (held)")
    assert running.stops[0].reason == f"backend fault: {said}"[:MOST_LETTERS]
    held = len(running.backend.applied)
    wait_until(lambda: len(running.backend.applied) > held + 2)


def test_the_holds_of_a_fault_go_on_whatever_else_fails(
    running: RunningHost, monkeypatch: pytest.MonkeyPatch
) -> None:
    wait_until(lambda: len(running.states) > 1)

    def fail() -> None:
        raise OSError("no more threads")

    monkeypatch.setattr(running.host, "_housekeep", fail)  # whose error is the fault, too
    wait_until(lambda: bool(running.stops))
    held = len(running.backend.applied)
    wait_until(lambda: len(running.backend.applied) > held + 2)


def test_a_command_refused_at_length_makes_a_stop_that_the_gate_can_read(
    running: RunningHost,
) -> None:
    running.backend.refusal = "driver: expected 7 joints, got " + "0.123456789, " * 6000
    running.backend.refuses_commands = True
    move_until(running, lambda: bool(running.stops))
    assert running.stops[0].reason.startswith("the backend refused a released command: driver")
    assert len(encode(running.stops[0])) < GATE_READS


def test_an_operators_long_stop_without_an_id_is_repeated_under_one_that_can_be_reset(
    running: RunningHost,
) -> None:
    wait_until(lambda: len(running.states) > 1)
    stop = StopLevel(stop_id=0, by="operator", reason="x" * 65_000)
    running.bus.publisher(KEYS.stop, StopLevel, Qos.HOT).put(stop)
    wait_until(lambda: any(heard.stop_id for heard in running.stops))
    own = next(heard for heard in running.stops if heard.stop_id)
    assert own.reason.startswith("stop without an id: by operator: xxx")
    assert len(own.reason) == MOST_LETTERS


def test_a_short_text_is_utf8_and_as_long_as_it_may_be() -> None:
    assert short_text("größe") == "größe"
    assert short_text("\udcff" * 600) == "\\udcff" * 83 + "\\u"
