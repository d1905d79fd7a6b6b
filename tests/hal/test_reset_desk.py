"""A request for a new episode: taken at once, answered when the tick loop knows."""

from __future__ import annotations

import threading

import pytest

from fairlead.errors import RefusedError
from fairlead.hal.core import HalCore
from fairlead.hal.reset_desk import ANSWER_WAIT_NS, DISARMED_WAIT_NS, ResetDesk
from fairlead.messages import Message, ResetEpisode, ResetEpisodeReply, encode

REPLY = ResetEpisodeReply(tick=3, episode_tick=2, held_ticks=1)


class Desk:
    """A desk whose clock and gate the test turns."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_ns = 0
        core = HalCore(1, "lockstep", 1, 1, 50_000_000)
        self.desk = ResetDesk(core, threading.Condition(), "hal", lambda: self.now_ns)
        self.disarmed = True
        monkeypatch.setattr(self.desk, "_is_disarmed", lambda: self.disarmed)
        self.answers: list[Message | Exception] = []

    def ask(self, seed: int) -> None:
        self.desk.handle(encode(ResetEpisode(seed=seed)), self.answers.append)


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch) -> Desk:
    return Desk(monkeypatch)


def test_the_callback_returns_at_once_and_a_second_request_is_refused_meanwhile(
    desk: Desk,
) -> None:
    desk.ask(1)
    assert desk.answers == []
    with pytest.raises(RefusedError, match="another reset_episode is running"):
        desk.ask(2)
    request = desk.desk.due()
    assert request is not None and request.seed == 1
    assert desk.desk.due() is None, "given out once"
    desk.desk.answer(request, REPLY)
    assert desk.answers == [REPLY]
    desk.ask(3)


def test_a_gate_that_stays_armed_refuses_it_after_a_moment(desk: Desk) -> None:
    desk.disarmed = False
    desk.ask(1)
    assert desk.desk.due() is None
    desk.now_ns = DISARMED_WAIT_NS - 1
    desk.desk.refuse_late()
    assert desk.answers == []
    desk.now_ns += 1
    desk.desk.refuse_late()
    assert "the gate may be armed" in str(desk.answers)


def test_a_scene_that_never_stands_still_is_refused_and_its_late_end_answers_nobody_else(
    desk: Desk,
) -> None:
    desk.ask(1)
    request = desk.desk.due()
    assert request is not None
    desk.now_ns = ANSWER_WAIT_NS
    desk.desk.refuse_late()
    assert "did not finish in 55 s" in str(desk.answers)
    desk.ask(2)
    desk.desk.answer(request, REPLY)
    assert REPLY not in desk.answers


def test_after_a_fault_every_request_is_refused_with_it(desk: Desk) -> None:
    desk.ask(1)
    desk.desk.close("backend fault: no bus")
    assert "backend fault: no bus" in str(desk.answers)
    with pytest.raises(RefusedError, match="backend fault: no bus"):
        desk.ask(2)
