"""An answer is taken only from the server that was held against the skill, and for its question."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from pydantic import JsonValue
from websockets.sync.server import ServerConnection

from bench.equipment.live_robot import wait_for
from fairlead.errors import ConfigError, PolicyError
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.remote.openpi import OpenpiPolicy
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from tests.runner.asked_policies import PI05, RLDX, ROWS, failure, observation
from tests.runner.half_open import HalfOpen
from tests.runner.policy_servers import (
    ANSWERS,
    OpenpiServer,
    RldxServer,
    openpi_actions,
    rldx_actions,
    rldx_rows,
)

pytestmark = pytest.mark.processes

Policies = list[OpenpiPolicy | RldxZmqPolicy]


@pytest.fixture
def opened() -> Iterator[Policies]:
    made: Policies = []
    yield made
    for policy in made:
        if isinstance(policy, OpenpiPolicy):
            policy._close()
        else:
            policy._link.close()


def openpi_policy(address: str, opened: Policies) -> OpenpiPolicy:
    skill = load_skill(PI05)
    opened.append(OpenpiPolicy.from_options(skill, skill.policy.options | {"address": address}))
    policy = opened[-1]
    assert isinstance(policy, OpenpiPolicy)
    return policy


def rows(request: object, number: int) -> bytes:
    return openpi_actions(ROWS)


def rldx_answer(request: object, number: int) -> bytes:
    return rldx_actions(rldx_rows(ROWS))


def test_an_episode_sees_nothing_of_the_probe_that_a_new_server_was_shown(
    openpi: Callable[[ANSWERS], OpenpiServer], opened: Policies
) -> None:
    first = openpi(rows)
    policy = openpi_policy(first.address, opened)
    port = int(first.address.rpartition(":")[2])
    first.close()
    second = OpenpiServer(rows, port)
    try:
        policy.reset()
        assert (len(second.requests), second.connections) == (1, 2), "the probe's, the episode's"
        policy.infer(observation(load_skill(PI05)))
        assert (len(second.requests), second.connections) == (2, 2)
    finally:
        policy._close()
        second.close()


def test_a_server_that_came_back_without_a_word_over_the_old_link_is_warmed_up_again(
    openpi: Callable[[ANSWERS], OpenpiServer],
    rldx: Callable[[ANSWERS], RldxServer],
    opened: Policies,
    closing: list[Any],
) -> None:
    """Its host lost its power: the old connection has no end, and the model is cold."""
    for policy_of, make, skill_id in (
        (OpenpiPolicy, lambda: openpi(rows), PI05),
        (RldxZmqPolicy, lambda: rldx(rldx_answer), RLDX),
    ):
        server, skill = make(), load_skill(skill_id)
        scheme, _, port = server.address.rpartition(":")
        closing.append(proxy := HalfOpen(int(port)))
        options = skill.policy.options | {"address": f"{scheme}:{proxy.port}"}
        policy = policy_of.from_options(skill, options)
        opened.append(policy)
        for asked, freezes in ((1, False), (2, True), (2, False), (3, True)):
            if freezes:
                proxy.freeze()
            policy.reset()
            assert len(server.requests) == asked, "a probe after each silent end, and no other"


class Repeating(OpenpiServer):
    """Sends its second answer twice."""

    has_repeated = False

    def _handle(self, link: ServerConnection) -> None:
        send = link.send

        def sent(message: bytes | str) -> None:
            send(message)
            if len(self.requests) == 2 and not self.has_repeated:
                self.has_repeated = True
                send(message)

        link.send = sent  # type: ignore[method-assign,assignment]
        super()._handle(link)


def test_an_answer_too_many_is_not_taken_for_the_next_question(opened: Policies) -> None:
    server = Repeating(rows)
    try:
        policy = openpi_policy(server.address, opened)
        policy.reset()
        policy.infer(observation(load_skill(PI05)))
        assert policy._link is not None
        came = policy._link.recv_messages.frames
        wait_for(lambda: came.qsize() > 0, "the second answer")
        with pytest.raises(PolicyError, match="sent a message that nobody asked for"):
            policy.infer(observation(load_skill(PI05)))
        policy.reset()  # goes on with another connection
        policy.infer(observation(load_skill(PI05)))
    finally:
        server.close()


def test_another_server_that_took_the_place_within_an_episode_is_not_believed(
    rldx: Callable[[ANSWERS], RldxServer], opened: Policies
) -> None:
    first = rldx(rldx_answer)
    skill = load_skill(RLDX)
    policy = RldxZmqPolicy.from_options(skill, skill.policy.options | {"address": first.address})
    opened.append(policy)
    policy.reset()
    seen = observation(skill)
    policy.infer(seen)
    port = int(first.address.rpartition(":")[2])
    first.close()
    second = RldxServer(rldx_answer, port)
    try:
        assert policy._link._monitor is not None and policy._link._monitor.poll(20_000)
        with pytest.raises(PolicyError, match="the link was lost meanwhile"):
            policy.infer(seen)
        asked = len(second.requests)
        policy.reset()
        assert len(second.requests) == asked + 1, "a probe"
        policy.infer(seen)
    finally:
        policy._link.close()
        second.close()


def test_openpi_is_asked_for_no_past_and_for_no_picture_in_the_place_of_the_state() -> None:
    skill = load_skill(PI05)
    name, spec = next(iter(skill.images.items()))
    with_past = skill.model_copy(
        update={"images": {**skill.images, name: spec.model_copy(update={"deltas": (-1, 0)})}}
    )
    with pytest.raises(ConfigError, match=r"deltas \[0\], as openpi takes one frame of each pict"):
        OpenpiPolicy.check_options(with_past, skill.policy.options)
    with pytest.raises(ConfigError, match="another name for state, prompt and each picture"):
        OpenpiPolicy.check_options(skill, {**skill.policy.options, "state_key": name})


def test_rldx_outputs_have_a_name_each() -> None:
    skill = load_skill(RLDX)
    twice: JsonValue = [{"name": "arm", "width": 6}, {"name": "arm", "width": 6}]
    with pytest.raises(ConfigError, match="actions: expected each name once"):
        RldxZmqPolicy.check_options(skill, {**skill.policy.options, "actions": twice})


def test_an_answer_that_is_too_large_is_not_taken_in(closing: list[Any]) -> None:
    server = RldxServer(lambda request, n: bytes(65 * 2**20))
    closing.append(server)
    skill = load_skill(RLDX)
    options: dict[str, JsonValue] = {"address": server.address, "warm_up_timeout_s": 2.0}
    text = failure(lambda: RldxZmqPolicy.from_options(skill, skill.policy.options | options))
    assert text.endswith("no answer within 2 s; the link was lost meanwhile")


def test_a_server_may_have_an_ipv6_address(closing: list[Any]) -> None:
    server = RldxServer(rldx_answer, host="[::1]")
    closing.append(server)
    skill = load_skill(RLDX)
    policy = RldxZmqPolicy.from_options(skill, skill.policy.options | {"address": server.address})
    assert len(policy.infer(observation(skill))) == len(ROWS)
    policy._link.close()


@pytest.mark.parametrize("address", ["tcp://*:5555", "tcp://a@b:1", "tcp://ü.invalid:5555"])
def test_an_address_that_cannot_be_dialled_is_no_server_s(address: str) -> None:
    skill = load_skill(RLDX)
    options = skill.policy.options | {"address": address}
    text = failure(lambda: RldxZmqPolicy.from_options(skill, options))
    assert text.startswith(f"rldx policy: no policy server at {address}: Invalid argument")
