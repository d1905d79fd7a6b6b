"""Policies behind servers: a real worker process, real sockets, servers that misbehave."""

from __future__ import annotations

import socket
import threading
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from typing import Any

import msgspec
import numpy as np
import pytest
import pytest_asyncio

from fairlead.errors import ConfigError, PolicyError
from fairlead.plugins import POLICIES
from fairlead.policy import Observation
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_skill_runner.policies.backends import policy_class
from fairlead_skill_runner.policies.remote.openpi import OpenpiPolicy
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from fairlead_skill_runner.policy_worker import PolicyWorker
from tests.runner.policy_servers import (
    ANSWERS,
    DEEP,
    OpenpiServer,
    RldxServer,
    openpi_actions,
    openpi_array,
    read_npy,
    read_openpi_array,
    rldx_actions,
    rldx_rows,
)

pytestmark = pytest.mark.processes

PI05 = "pi05-robocasa365-human300-nf4"
RLDX = "rldx1-ft-rc365-nf4"
ROWS = np.random.default_rng(5).uniform(-1, 1, (4, 12)).astype(np.float32)


def observation(skill: SkillManifest, tick: int = 9) -> Observation:
    rng = np.random.default_rng(tick)
    images = {
        name: rng.integers(0, 256, (spec.height, spec.width, 3)).astype(np.uint8)
        for name, spec in skill.images.items()
    }
    return Observation(tick, rng.normal(size=16), "put it there", images)


Ask = Callable[..., PolicyWorker]


@pytest.fixture
def closing() -> Iterator[list[Any]]:
    opened: list[Any] = []
    yield opened
    for one in reversed(opened):
        one.close()


@pytest.fixture
def openpi(closing: list[Any]) -> Callable[[ANSWERS], OpenpiServer]:
    def make(answers: ANSWERS) -> OpenpiServer:
        closing.append(OpenpiServer(answers))
        return closing[-1]  # type: ignore[no-any-return]

    return make


@pytest.fixture
def rldx(closing: list[Any]) -> Callable[[ANSWERS], RldxServer]:
    def make(answers: ANSWERS) -> RldxServer:
        closing.append(RldxServer(answers))
        return closing[-1]  # type: ignore[no-any-return]

    return make


@pytest_asyncio.fixture
async def worker() -> AsyncIterator[Ask]:
    workers: list[PolicyWorker] = []

    def make(skill_id: str, address: str, **options: float) -> PolicyWorker:
        skill = load_skill(skill_id)
        changed = skill.policy.options | {"address": address} | options
        workers.append(PolicyWorker(POLICIES.find(skill.policy.backend), skill, changed))
        return workers[-1]

    yield make
    for one in reversed(workers):
        await one.close()


def bits(answer: object) -> bytes:
    """Of rows; a policy may answer with an end of its goal too."""
    assert isinstance(answer, np.ndarray)
    return answer.tobytes()


def failure(call: Callable[[], object]) -> str:
    with pytest.raises(PolicyError) as caught:
        call()
    return str(caught.value)


async def refusal(call: Awaitable[object]) -> str:
    with pytest.raises(PolicyError) as caught:
        await call
    return str(caught.value)


def unused_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.mark.asyncio
async def test_openpi_server_gets_state_prompt_and_pictures_and_its_rows_come_back_bit_for_bit(
    openpi: Callable[[ANSWERS], OpenpiServer], worker: Ask
) -> None:
    server = openpi(lambda request, n: openpi_actions(ROWS))
    asked = worker(PI05, server.address)
    await asked.load()
    await asked.reset()
    seen = observation(load_skill(PI05))
    assert bits(await asked.infer(seen)) == ROWS.tobytes()
    warm_up, request = server.requests
    np.testing.assert_array_equal(
        read_openpi_array(warm_up["observation/state"]), np.full(16, 0.5, np.float32)
    )
    assert request.keys() == {"observation/state", "prompt", *seen.images}
    assert request["prompt"] == "put it there"
    np.testing.assert_array_equal(
        read_openpi_array(request["observation/state"]), seen.state.astype(np.float32)
    )
    for name, image in seen.images.items():
        np.testing.assert_array_equal(read_openpi_array(request[name]), image)
    assert server.connections == 2, "one for the warm-up, one for the episode"


@pytest.mark.asyncio
async def test_openpi_rows_of_float64_are_taken_as_float32(
    openpi: Callable[[ANSWERS], OpenpiServer], worker: Ask
) -> None:
    server = openpi(lambda request, n: openpi_actions(ROWS.astype(np.float64)))
    asked = worker(PI05, server.address)
    await asked.load()
    assert bits(await asked.infer(observation(load_skill(PI05)))) == ROWS.tobytes()


@pytest.mark.asyncio
async def test_no_openpi_server_is_one_error_with_address_and_how_to_start_one(worker: Ask) -> None:
    address = f"ws://127.0.0.1:{unused_port()}"
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
    address = f"tcp://127.0.0.1:{unused_port()}"
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


BROKEN_OPENPI: dict[str, tuple[bytes | bytearray | str | None, str]] = {
    "too narrow": (openpi_actions(ROWS[:, :11]),
                   "expected actions as floats [1 to 50, 12], got float32 [4, 11]"),
    "one row, flat": (openpi_actions(ROWS[0]),
                      "expected actions as floats [1 to 50, 12], got float32 [12]"),
    "whole numbers": (openpi_actions(ROWS.astype(np.int64)),
                      "expected actions as floats [1 to 50, 12], got int64 [4, 12]"),
    "no rows": (openpi_actions(ROWS[:0]),
                "expected actions as floats [1 to 50, 12], got float32 [0, 12]"),
    "no actions": (msgspec.msgpack.encode({}),
                   "expected an output actions, got none of that name"),
    "other names": (msgspec.msgpack.encode({"action": 1, "timing": 2}),
                    "expected an output actions, got none of that name (valid: action, timing)"),
    "more rows than the skill takes": (
        openpi_actions(np.zeros((51, 12), np.float32)),
        "expected actions as floats [1 to 50, 12], got float32 [51, 12]"),
    "a traceback that goes on after its error": (
        "Traceback ...\njax.errors.TracerError: x is traced\n-----\nFor simplicity, JAX has "
        "removed its internal frames from the traceback.\n",
        "failed: jax.errors.TracerError: x is traced"),
    "a number": (b"\x07", "expected a map with actions, got int"),
    "no message": (b"\xc1garbage", "answered no message: "),
    "less data than its shape": (
        msgspec.msgpack.encode({"actions": openpi_array(ROWS) | {b"shape": [400, 12]}}),
        "answered no message: cannot reshape array of size 48"),
    "an array of objects": (
        msgspec.msgpack.encode({"actions": openpi_array(ROWS) | {b"dtype": "|O"}}),
        "answered no message: an array of |O"),
    "a traceback": ("Traceback ...\n  ...\nKeyError: 'state'\n", "failed: KeyError: 'state'"),
    "deeply nested": (DEEP, "answered no message: "),
    "a shape of nothing": (
        msgspec.msgpack.encode({"actions": openpi_array(ROWS) | {b"shape": [None, 12]}}),
        "answered no message: "),
    "hangs up": (None, "closed the connection: "),
    "hangs up in the middle": (bytearray(b"\x82\x7e\xff\xff" + DEEP[:1000]),
                               "closed the connection: "),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN_OPENPI)
def test_an_openpi_server_that_answers_garbage_is_refused_before_any_claim(
    openpi: Callable[[ANSWERS], OpenpiServer], name: str
) -> None:
    answer, text = BROKEN_OPENPI[name]
    server = openpi(lambda request, n: answer)
    skill = load_skill(PI05)
    options = skill.policy.options | {"address": server.address}
    said = failure(lambda: OpenpiPolicy.from_options(skill, options))
    assert said.startswith("openpi policy: ")
    assert text in said


@pytest.mark.asyncio
async def test_rldx_server_gets_named_arrays_and_its_named_outputs_become_one_vector(
    rldx: Callable[[ANSWERS], RldxServer], worker: Ask
) -> None:
    rows = ROWS.copy()
    rows[:, 6] = [0.0, 0.49, 0.5, 1.0]  # probabilities of closed
    rows[:, 11] = [1.0, 0.6, 0.4, 0.0]
    server = rldx(lambda request, n: rldx_actions(rldx_rows(rows)))
    asked = worker(RLDX, server.address)
    await asked.load()
    await asked.reset()
    seen = observation(load_skill(RLDX))
    wanted = rows.copy()
    wanted[:, 6] = [-1, -1, 1, 1]
    wanted[:, 11] = [1, 1, -1, -1]
    assert bits(await asked.infer(seen)) == wanted.tobytes()
    await asked.infer(seen)
    _, first, second = server.requests
    state = seen.state.astype(np.float32)
    ranges = {"end_effector_position_relative": slice(0, 3), "base_position": slice(7, 10),
              "end_effector_rotation_relative": slice(3, 7), "base_rotation": slice(10, 14),
              "gripper_qpos": slice(14, 16)}  # fmt: skip
    for name, part in ranges.items():
        array = read_npy(first["observation"][f"state.{name}"])
        assert array.dtype == np.float32
        np.testing.assert_array_equal(array, state[None, None, part])
    for name, image in seen.images.items():
        array = read_npy(first["observation"][f"video.{name}"])
        np.testing.assert_array_equal(array, image[None, None])
    assert first["observation"]["annotation.human.task_description"] == ["put it there"]
    assert [r["options"]["reset_memory"] for r in (first, second)] == [[True], [False]]
    assert first["options"]["session_ids"] == second["options"]["session_ids"]


GOOD = rldx_rows(ROWS)
LARGE_NPY = (
    b"\x93NUMPY\x01\x00\x4f\x00"
    + b"{'descr': '<f4', 'fortran_order': False, 'shape': (10000000, 10000000), }".ljust(78)
    + b"\n"
)
NARROW = "expected action.base_motion as floats [1 to 16, 4], got "
BROKEN_RLDX: dict[str, tuple[bytes, str]] = {
    "too narrow": (rldx_actions(GOOD | {"base_motion": ROWS[:, :3]}), NARROW + "float32 [4, 3]"),
    "an output left out": (
        rldx_actions({n: a for n, a in GOOD.items() if n != "base_motion"}),
        "expected an output action.base_motion, got none of that name (valid: action.end_eff"),
    "unequal rows": (rldx_actions(GOOD | {"base_motion": ROWS[:3, 7:11]}),
                     "expected as many rows of every action, got 4, 4, 4, 3, 4"),
    "an error": (msgspec.msgpack.encode({"error": "no such key"}), "failed: no such key"),
    "a map": (msgspec.msgpack.encode({"action": 1}),
              "expected a list that begins with a map, got dict"),
    "no message": (b"\xc1", "answered no message: "),
    "an array of no bytes": (
        msgspec.msgpack.encode([{"action.base_motion": {"__ndarray_class__": True}}, {}]),
        "answered no message: an array without its bytes"),
    "deeply nested": (DEEP, "answered no message: "),
    "an array larger than any memory": (
        msgspec.msgpack.encode([{"a": {"__ndarray_class__": True, "as_npy": LARGE_NPY}}, {}]),
        "answered no message: "),
    "an array cut short": (
        msgspec.msgpack.encode([{"a": {"__ndarray_class__": True, "as_npy": b"\x93NUMPY"}}, {}]),
        "answered no message: "),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN_RLDX)
def test_an_rldx_server_that_answers_garbage_is_refused_before_any_claim(
    rldx: Callable[[ANSWERS], RldxServer], name: str
) -> None:
    answer, text = BROKEN_RLDX[name]
    server = rldx(lambda request, n: answer)
    skill = load_skill(RLDX)
    options = skill.policy.options | {"address": server.address}
    said = failure(lambda: RldxZmqPolicy.from_options(skill, options))
    assert said.startswith("rldx policy: ")
    assert text in said


@pytest.mark.parametrize(
    ("skill_id", "options", "text"),
    [
        (PI05, {"address": "127.0.0.1:8000"},
         "openpi policy: 1 problem(s):\n  address: String should match"),
        (PI05, {"answer_timeout_s": 5.0},
         "openpi policy: answer_timeout_s: expected less than the skill's inference_timeout_s, "
         "5 s, got 5 s"),
        (RLDX, {"address": "ws://127.0.0.1:1"},
         "rldx policy: 1 problem(s):\n  address: String should match"),
        (RLDX, {"state": {"all": [0, 14]}},
         "rldx policy: state: expected every index of 0..15 once, got indices [0, 1, 2, 3, 4"),
        (RLDX, {"actions": [{"name": "a", "width": 11}]},
         "rldx policy: actions: expected 12 numbers in all, got 11"),
        (RLDX, {"start": ""},
         "rldx policy: 1 problem(s):\n  start: String should have at least 1 character"),
    ],
)  # fmt: skip
def test_options_that_do_not_fit_are_named(
    skill_id: str, options: dict[str, Any], text: str
) -> None:
    skill = load_skill(skill_id)
    policy = OpenpiPolicy if skill_id == PI05 else RldxZmqPolicy
    with pytest.raises(ConfigError) as caught:
        policy.from_options(skill, skill.policy.options | options)
    assert text in str(caught.value)
