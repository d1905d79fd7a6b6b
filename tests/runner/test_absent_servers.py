"""Servers of policies that are not there, went away, are busy or late."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from fairlead.plugins import POLICIES
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.backends import policy_class
from fairlead_tools.supervisor.this_host import free_ports
from tests.runner.asked_policies import (
    PI05,
    RLDX,
    ROWS,
    Ask,
    bits,
    failure,
    observation,
    refusal,
)
from tests.runner.policy_servers import (
    ANSWERS,
    OpenpiServer,
    RldxServer,
    openpi_actions,
    rldx_actions,
    rldx_rows,
)

pytestmark = pytest.mark.processes


@pytest.mark.asyncio
async def test_no_openpi_server_is_one_error_with_address_and_how_to_start_one(worker: Ask) -> None:
    address = f"ws://127.0.0.1:{free_ports(1)[0]}"
    assert await refusal(worker(PI05, address).load()) == (
        f"policy worker: loading failed: openpi policy: no policy server at {address}: "
        "[Errno 111] Connection refused\n"
        "  start one: uv run scripts/serve_policy.py --port 8000 policy:checkpoint "
        "--policy.config CONFIG --policy.dir CHECKPOINT (in a checkout of openpi)\n"
        "  or, if one runs elsewhere, in the runner's options in the deployment file:\n"
        "    servers: {pi05-robocasa365-human300-nf4: ADDRESS}"
    )


@pytest.mark.asyncio
async def test_no_rldx_server_is_one_error_with_address_and_how_to_start_one(worker: Ask) -> None:
    address = f"tcp://127.0.0.1:{free_ports(1)[0]}"
    assert await refusal(worker(RLDX, address, connect_timeout_s=0.2).load()) == (
        f"policy worker: loading failed: rldx policy: no policy server at {address}: "
        "no answer within 0.2 s\n"
        "  start one: uv run python rldx/eval/run_rldx_server.py --model-path "
        "RLWRLD/RLDX-1-FT-RC365 --embodiment-tag GENERAL_EMBODIMENT --use-sim-policy-wrapper "
        "--host 127.0.0.1 --port 5555 (in a checkout of RLDX-1)\n"
        "  or, if one runs elsewhere, in the runner's options in the deployment file:\n"
        "    servers: {rldx1-ft-rc365-nf4: ADDRESS}"
    )


@pytest.mark.asyncio
async def test_something_that_listens_but_says_nothing_is_no_openpi_server(
    closing: list[Any], worker: Ask
) -> None:
    silent = socket.create_server(("127.0.0.1", 0))
    closing.append(silent)
    address = f"ws://127.0.0.1:{silent.getsockname()[1]}"
    text = await refusal(worker(PI05, address, connect_timeout_s=0.2).load())
    assert f"{address} listens, but sent no websocket handshake within 0.2 s: it is busy" in text
    assert "one is started with: uv run scripts/serve_policy.py" in text


@pytest.mark.asyncio
async def test_a_server_that_went_away_is_noticed_when_the_next_goal_starts(
    openpi: Callable[[ANSWERS], OpenpiServer],
    rldx: Callable[[ANSWERS], RldxServer],
    worker: Ask,
) -> None:
    pi05 = openpi(lambda request, n: openpi_actions(ROWS))
    asked = worker(PI05, pi05.address)
    await asked.load()
    pi05.close()
    assert f"no policy server at {pi05.address}" in await refusal(asked.reset())
    other = rldx(lambda request, n: rldx_actions(rldx_rows(ROWS)))
    asked = worker(RLDX, other.address, connect_timeout_s=0.2)
    await asked.load()
    other.close()
    assert f"no policy server at {other.address}" in await refusal(asked.reset())


@pytest.mark.parametrize("skill_id", [PI05, RLDX])
@pytest.mark.asyncio
async def test_a_server_that_was_started_anew_compiles_before_the_next_goal_claims_anything(
    closing: list[Any], worker: Ask, skill_id: str
) -> None:
    def serve(port: int = 0) -> OpenpiServer | RldxServer:
        if skill_id == PI05:
            closing.append(OpenpiServer(lambda request, n: openpi_actions(ROWS), port))
        else:
            closing.append(RldxServer(lambda r, n: rldx_actions(rldx_rows(np.abs(ROWS))), port))
        return closing[-1]  # type: ignore[no-any-return]

    first = serve()
    asked = worker(skill_id, first.address)
    await asked.load()
    await asked.reset()
    await asked.reset()
    assert len(first.requests) == 1, "a server that stayed is warm"
    first.close()
    closing.remove(first)
    again = serve(int(first.address.rpartition(":")[2]))
    await asked.reset()
    assert len(again.requests) == 1
    await asked.infer(observation(load_skill(skill_id)))
    assert len(again.requests) == 2


def test_an_rldx_server_that_is_started_anew_at_once_is_noticed_each_time(
    closing: list[Any],
) -> None:
    def serve(port: int = 0) -> RldxServer:
        closing.append(RldxServer(lambda r, n: rldx_actions(rldx_rows(np.abs(ROWS))), port))
        return closing[-1]  # type: ignore[no-any-return]

    server, skill = serve(), load_skill(RLDX)
    kind = policy_class(POLICIES.find(skill.policy.backend))
    policy = kind.from_options(skill, skill.policy.options | {"address": server.address})
    compiled = []
    for _ in range(30):
        server.close()
        closing.remove(server)
        server = serve(int(server.address.rpartition(":")[2]))
        policy.reset()
        compiled.append(len(server.requests))
    assert compiled == [1] * 30
    server.close()
    closing.remove(server)
    assert f"no policy server at {server.address}" in failure(policy.reset)


@pytest.mark.asyncio
async def test_a_busy_rldx_server_is_not_called_absent(
    rldx: Callable[[ANSWERS], RldxServer], worker: Ask
) -> None:
    def hang(request: Any, number: int) -> bytes:
        server.go_on.wait(20)
        return rldx_actions(rldx_rows(np.abs(ROWS)))

    server = rldx(hang)
    first = worker(RLDX, server.address, warm_up_timeout_s=0.2)
    assert "no answer within 0.2 s" in await refusal(first.load())
    second = worker(RLDX, server.address, connect_timeout_s=0.2)
    assert f"{server.address} listens, but sent no answer to a ping" in await refusal(second.load())


LATE_OPENPI = "openpi policy: no answer from {address} within 0.2 s"
LATE_RLDX = "rldx policy: {address}: no answer within 0.2 s"


@pytest.mark.parametrize("skill_id", [PI05, RLDX])
@pytest.mark.asyncio
async def test_a_late_answer_is_an_error_and_never_the_answer_to_the_next_question(
    openpi: Callable[[ANSWERS], OpenpiServer],
    rldx: Callable[[ANSWERS], RldxServer],
    worker: Ask,
    skill_id: str,
) -> None:
    late, wanted = np.full_like(ROWS, 0.25), np.abs(ROWS)
    wanted[:, [6, 11]] = 1.0
    go_on = threading.Event()

    def answers(request: Any, number: int) -> bytes:
        if number == 1:
            go_on.wait(10)
        rows = late if number == 1 else wanted
        return openpi_actions(rows) if skill_id == PI05 else rldx_actions(rldx_rows(rows))

    server = openpi(answers) if skill_id == PI05 else rldx(answers)
    asked = worker(skill_id, server.address, answer_timeout_s=0.2)
    await asked.load()
    await asked.reset()
    seen = observation(load_skill(skill_id))
    text = (LATE_OPENPI if skill_id == PI05 else LATE_RLDX).format(address=server.address)
    assert await refusal(asked.infer(seen)) == f"policy worker: inference failed: {text}"
    go_on.set()
    await asked.load()
    await asked.reset()
    assert bits(await asked.infer(seen)) == wanted.tobytes()
