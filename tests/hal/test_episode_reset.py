"""A request for a new episode: a task waits for it, the tick thread carries it out."""

from __future__ import annotations

import asyncio

import pytest

from fairlead.errors import RefusedError
from fairlead.hal import episode_reset
from fairlead.hal.core import HalCore
from fairlead.hal.episode_reset import SEEN_NS, SILENT_NS, EpisodeResetHandler
from fairlead.hal.inbox import SharedCore
from fairlead.messages import GateState, ResetEpisode, ResetEpisodeReply, encode
from tests.client.turns import turns
from tests.hal.gate_messages import SESSION, lease

REPLY = ResetEpisodeReply(tick=3, episode_tick=2, held_ticks=1)

pytestmark = pytest.mark.asyncio


class RunningHandler:
    """A handler, and the tick thread's part of it."""

    def __init__(self, answer_wait_s: float = 55.0) -> None:
        self.core = SharedCore(HalCore(SESSION, "lockstep", 1, 1, 50_000_000))
        self.handler = EpisodeResetHandler(self.core, "hal", answer_wait_s)
        self.say(GateState.DISARMED)

    def say(self, state: GateState, seq: int = 1, came_ns: int = 0) -> None:
        """The gate's newest lease."""
        self.core.change(lambda core: core.on_lease(lease(seq, 1, state=state), came_ns))

    async def ask(self, seed: int) -> asyncio.Task[ResetEpisodeReply]:
        """Begin to ask; the request is there when this returns."""
        asking = asyncio.create_task(self.handler.handle(encode(ResetEpisode(seed=seed))))
        await turns()
        return asking

    def due(self) -> ResetEpisode | None:
        return self.core.change(self.handler.due)

    def finish(self, request: ResetEpisode) -> None:
        """It stands still, and the gate has been silent since the status said so."""
        self.handler.finish(request, REPLY, ready_ns=0)
        self.handler.answer_finished(SILENT_NS)

    async def refusal(self, asking: asyncio.Task[ResetEpisodeReply]) -> str:
        with pytest.raises(RefusedError) as caught:
            await asking
        return caught.value.reason


async def test_a_second_request_is_refused_while_the_first_waits() -> None:
    handler = RunningHandler()
    asking = await handler.ask(1)
    assert await handler.refusal(await handler.ask(2)) == "another reset_episode is running"
    request = handler.due()
    assert request is not None and request.seed == 1
    assert handler.due() is None, "given out once"
    handler.finish(request)
    assert handler.due() is None, "nor after its answer"
    assert await asking == REPLY
    await handler.ask(3)
    assert handler.due() == ResetEpisode(seed=3)


async def test_a_gate_that_stays_armed_refuses_it_after_a_moment() -> None:
    handler = RunningHandler()
    handler.say(GateState.ARMED, seq=2)
    asking = await handler.ask(1)
    assert handler.due() is None
    assert await handler.refusal(asking) == "reset_episode needs a disarmed gate, it is armed"
    handler.say(GateState.DISARMED, seq=3)
    assert handler.due() is None, "nobody waits for it any more"


async def test_a_gate_that_disarms_a_moment_later_lets_it_begin() -> None:
    handler = RunningHandler()
    handler.say(GateState.ARMED, seq=2)
    asking = await handler.ask(1)
    assert handler.due() is None
    handler.say(GateState.DISARMED, seq=3)
    request = handler.due()
    assert request is not None
    handler.finish(request)
    assert await asking == REPLY


async def test_a_tick_that_outlasts_the_wait_for_a_disarmed_gate_does_not_refuse_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(episode_reset, "DISARMED_WAIT_S", 0.0)
    handler = RunningHandler()
    asking = await handler.ask(1)
    await turns()
    request = handler.due()
    assert request is not None, "the gate is disarmed, and whoever asked still waits"
    handler.finish(request)
    assert await asking == REPLY


async def test_a_scene_that_never_stands_still_is_refused_and_its_end_answers_no_other() -> None:
    handler = RunningHandler(answer_wait_s=0.01)
    asking = await handler.ask(1)
    request = handler.due()
    assert request is not None
    assert await handler.refusal(asking) == "reset_episode did not finish in 0.01 s"
    other = await handler.ask(2)
    handler.finish(request)
    await turns()
    assert not other.done()
    other.cancel()


async def test_after_a_fault_every_request_is_refused_with_it() -> None:
    handler = RunningHandler()
    asking = await handler.ask(1)
    handler.handler.close("backend fault: no bus")
    assert await handler.refusal(asking) == "backend fault: no bus"
    assert await handler.refusal(await handler.ask(2)) == "backend fault: no bus"


async def test_it_is_answered_once_the_gate_has_read_that_it_is_over() -> None:
    handler = RunningHandler()
    asking = await handler.ask(1)
    request = handler.due()
    assert request is not None
    ready_ns = 7
    handler.handler.finish(request, REPLY, ready_ns)
    for now_ns in (ready_ns, ready_ns + SEEN_NS - 1):
        handler.say(GateState.DISARMED, seq=now_ns, came_ns=now_ns)
        handler.handler.answer_finished(now_ns)
        await turns()
        assert not asking.done()
    handler.say(GateState.DISARMED, seq=ready_ns + SEEN_NS, came_ns=ready_ns + SEEN_NS)
    handler.handler.answer_finished(ready_ns + SEEN_NS)
    assert await asking == REPLY


async def test_a_gate_that_is_silent_after_it_is_not_waited_for_long() -> None:
    handler = RunningHandler()
    asking = await handler.ask(1)
    request = handler.due()
    assert request is not None
    handler.handler.finish(request, REPLY, ready_ns=7)
    handler.handler.answer_finished(6 + SILENT_NS)
    await turns()
    assert not asking.done()
    handler.handler.answer_finished(7 + SILENT_NS)
    assert await asking == REPLY
