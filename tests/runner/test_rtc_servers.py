"""Real-time chunking through an RLDX server: the rows that act meanwhile reach it, or none do.

The server here is a small one of ours, which reads options as RLDX-1's does; `tests/peers` has
RLDX-1's own code do it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import msgspec
import numpy as np
import pytest

from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from tests.runner.asked_policies import FITTING, RLDX, Ask, bits, failure, late, observation
from tests.runner.policy_servers import (
    ANSWERS,
    RLDX_SHARES,
    Array,
    RldxServer,
    modality_config,
    read_npy,
    rldx_actions,
)

pytestmark = pytest.mark.processes

Load = Callable[..., tuple[RldxServer, RldxZmqPolicy]]

ITS_ORDER = list(reversed(RLDX_SHARES))
CONFIG = modality_config(**(FITTING | {"actions": ITS_ORDER}))
WIDEST = 64
NUMBERED = np.arange(48, dtype=np.float32).reshape(4, 12)
"""What the skill gets, in the order of its actions, when nothing is to go on from."""


def with_rtc(request: Any, number: int, mends: bool = True) -> bytes:
    """Its own rows after the rows it is given, which it takes in its own order.

    Of a request that says nothing of them it makes something of its own: the rows of before.
    """
    options = request["options"]
    rows = NUMBERED.copy()
    if "action_prefix" not in options:
        return rldx_actions(by_name(rows - 1000))
    prefix = read_npy(options["action_prefix"])
    if prefix.shape[2] > WIDEST:
        text = f"client action_prefix dim {prefix.shape[2]} exceeds model max_action_dim {WIDEST}"
        return msgspec.msgpack.encode({"error": text})
    length = options["rtc_prefix_len"]
    if length and not mends:
        return msgspec.msgpack.encode({"error": "State dict required for relative action"})
    assert prefix.shape[::2] == (1, 12)
    rows[:length] = prefix[0, :length, np.argsort(columns(ITS_ORDER))].T
    return rldx_actions(by_name(rows))


def columns(names: list[str]) -> list[int]:
    return [column for name in names for column in range(*RLDX_SHARES[name])]


def by_name(rows: Array) -> dict[str, Array]:
    return {name: rows[:, first:last] for name, (first, last) in RLDX_SHARES.items()}


def without_rtc(request: Any, number: int) -> bytes:
    return rldx_actions(by_name(NUMBERED))


@pytest.fixture
def load(rldx: Callable[[ANSWERS], RldxServer]) -> Iterator[Load]:
    """A server that answers so, and the policy that is behind it."""
    made: list[RldxZmqPolicy] = []

    def make(
        answers: ANSWERS, config: Any = CONFIG, **options: Any
    ) -> tuple[RldxServer, RldxZmqPolicy]:
        server = rldx(answers)
        server.config = config
        skill = load_skill(RLDX)
        given = skill.policy.options | {"address": server.address} | options
        made.append(RldxZmqPolicy.from_options(skill, given))
        return server, made[-1]

    yield make
    for policy in made:
        policy._link.close()


def told(server: RldxServer) -> tuple[Array, int]:
    options = server.requests[-1]["options"]
    return read_npy(options["action_prefix"]), options["rtc_prefix_len"]


def test_the_rows_that_act_meanwhile_go_to_the_server_and_its_answer_goes_on_from_them(
    load: Load, capfd: pytest.CaptureFixture[str]
) -> None:
    server, policy = load(with_rtc, rtc=True)
    assert policy.continues_rows
    assert (
        f"{server.address} goes on from a prefix of one row within 0 of" in capfd.readouterr().err
    )
    policy.reset()
    seen, acting = late(observation(load_skill(RLDX)), 12, 3)
    answer = policy.infer(seen)
    sent, length = told(server)
    assert (sent.shape, sent.dtype.name, length) == ((1, 3, 12), "float32", 3)
    assert sent[0].tobytes() == acting[:, columns(ITS_ORDER)].tobytes()
    assert answer.tobytes() == np.concatenate([acting, NUMBERED[3:]]).tobytes()


@pytest.mark.asyncio
async def test_they_reach_a_policy_in_its_worker_process(
    rldx: Callable[[ANSWERS], RldxServer], worker: Ask
) -> None:
    server = rldx(with_rtc)
    server.config = CONFIG
    asked = worker(RLDX, server.address, rtc=True)
    await asked.load()
    await asked.reset()
    seen, acting = late(observation(load_skill(RLDX)), 12, 3)
    assert bits(await asked.infer(seen)) == np.concatenate([acting, NUMBERED[3:]]).tobytes()


def test_where_no_row_acts_meanwhile_the_server_is_told_so(
    load: Load,
) -> None:
    server, policy = load(with_rtc, rtc=True)
    policy.reset()
    assert policy.infer(observation(load_skill(RLDX))).tobytes() == NUMBERED.tobytes()
    sent, length = told(server)
    assert (sent.shape, length) == ((1, 0, 12), 0)


def test_a_skill_without_rtc_switches_it_off_in_every_request(
    load: Load, capfd: pytest.CaptureFixture[str]
) -> None:
    server, policy = load(with_rtc)
    assert not policy.continues_rows
    assert (
        f"{server.address}: every request switches its real-time chunking off"
        in capfd.readouterr().err
    )
    policy.reset()
    seen, _ = late(observation(load_skill(RLDX)), 12, 3)
    assert policy.infer(seen).tobytes() == NUMBERED.tobytes()
    sent, length = told(server)
    assert (sent.shape, length) == ((1, 0, 12), 0)


def test_a_server_that_reads_no_prefix_is_asked_once_and_then_without(
    load: Load,
) -> None:
    server, policy = load(without_rtc)
    policy.infer(late(observation(load_skill(RLDX)), 12, 3)[0])
    _, asked = server.requests
    assert asked["options"].keys() == {"session_ids", "reset_memory"}


RTC_OFF = (
    " takes no prefix: start RLDX-1's server with --rtc-inference-mode and "
    "--rtc-inference-delay, or leave rtc out"
)


@pytest.mark.parametrize(
    ("answers", "config", "text"),
    [
        (without_rtc, CONFIG, RTC_OFF),
        (with_rtc, {}, "rtc: expected a server that tells the order of its actions, got none told"),
        (partial(with_rtc, mends=False), CONFIG, "failed: State dict required for relative action"),
    ],
)
def test_a_server_that_cannot_go_on_from_rows_is_refused_at_load(
    load: Load, answers: ANSWERS, config: Any, text: str
) -> None:
    assert text in failure(lambda: load(answers, config, rtc=True))
