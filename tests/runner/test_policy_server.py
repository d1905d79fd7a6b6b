"""``fairlead serve-policy``: its answers are the policy's own; what does not fit is said."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from websockets.asyncio.client import ClientConnection
from websockets.asyncio.client import connect as connect_async
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from fairlead.errors import ConfigError, PolicyError
from fairlead.policy import Observation, Policy
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_skill_runner.policies.oracle.policy import OraclePolicy
from fairlead_skill_runner.policies.remote.openpi import OpenpiPolicy
from fairlead_skill_runner.policies.remote.openpi_wire import decode, encode
from fairlead_skill_runner.policy_server import PolicyServer, served_policy
from fairlead_tools.skills.skeleton import skill_skeleton
from tests.cli.command import fairlead_here
from tests.runner.broken_policies import Exits, Lists, Misbehaving, Raises, Spells, Wordless
from tests.runner.served_skill import served

pytestmark = pytest.mark.processes

SKILL = load_skill("oracle-counter-to-cabinet")
KEYS = ("observation/state", "prompt")
STATES = np.random.default_rng(3).uniform(-1, 1, (3, 30)).astype(np.float32).astype(np.float64)


def test_each_connection_is_an_episode_and_its_answers_are_the_policy_s_bit_for_bit() -> None:
    asked: dict[str, Any] = {"start": "-", "connect_timeout_s": 4.0, "answer_timeout_s": 4.0}
    with served(SKILL.id) as address:
        for _ in range(2):
            policy = OpenpiPolicy.from_options(SKILL, asked | {"address": address})
            policy.reset()
            alone = OraclePolicy(SKILL.horizon)
            for number, state in enumerate(STATES):
                wanted = alone.infer(Observation(1 + 8 * number, state, ""))
                assert policy.infer(Observation(5, state, "")).tobytes() == wanted.tobytes()
            policy._close()


def test_the_policy_of_another_skill_is_refused_though_all_its_dimensions_are_the_same() -> None:
    other = SKILL.model_copy(update={"id": "open-the-cabinet", "rate_hz": 10.0})
    asked: dict[str, Any] = {"start": "-", "connect_timeout_s": 4.0, "answer_timeout_s": 4.0}
    with served(SKILL.id) as address:
        with pytest.raises(PolicyError) as refused:
            OpenpiPolicy.from_options(other, asked | {"address": address})
        assert str(refused.value) == (
            f"openpi policy: {address} serves another policy than skill open-the-cabinet asks for:"
            "\n  skill: expected open-the-cabinet, it serves oracle-counter-to-cabinet"
            "\n  rate_hz: expected 10.0, it serves 20.0"
            "\n  for a skill of another name: serves: ID in the policy's options"
        )
        renamed = SKILL.model_copy(update={"id": "open-the-cabinet", "version": "9.0.0"})
        options = asked | {"address": address, "serves": SKILL.id}
        OpenpiPolicy.from_options(renamed, options)._close()


def test_a_copy_of_the_skill_with_other_joints_or_scales_is_refused() -> None:
    asked: dict[str, Any] = {"start": "-", "connect_timeout_s": 4.0, "answer_timeout_s": 4.0}
    document = SKILL.model_dump(mode="json", exclude_none=True)
    slot = next(one for one in document["action_contract"]["slots"] if "scale" in one)
    slot["scale"] = np.multiply(slot["scale"], 0.5).tolist()
    edited = SkillManifest.model_validate(document)
    said = "\n  contracts: expected [0-9a-f]{16}, it serves "
    with served(SKILL.id) as address, pytest.raises(PolicyError, match=said):
        OpenpiPolicy.from_options(edited, asked | {"address": address})


def test_a_picture_is_served_as_the_client_s_skill_declares_it_and_not_changed_again() -> None:
    skill = load_skill("bc-reach-cube")
    options: dict[str, Any] = {"start": "-", "connect_timeout_s": 4.0, "answer_timeout_s": 4.0}
    eye = np.random.default_rng(4).uniform(0, 1, (3, 64, 64)).astype(np.float32)
    seen = Observation(1, np.full(8, 0.5), "", {"eye": eye})
    wanted = served_policy(skill).infer(seen)
    with served(skill.id) as address:
        policy = OpenpiPolicy.from_options(skill, options | {"address": address})
        policy.reset()
        got = policy.infer(seen)
        policy._close()
    assert isinstance(wanted, np.ndarray) and got.tobytes() == wanted.tobytes()


def test_who_has_no_key_or_comes_second_is_turned_away_and_the_first_goes_on() -> None:
    with served(SKILL.id, key="k3y") as address:
        twice = [("Authorization", "Api-Key k3y")] * 2
        for headers in ({}, {"Authorization": "Api-Key other"}, twice):
            with pytest.raises(InvalidStatus, match="401"):
                connect(address, additional_headers=headers)
        key = {"Authorization": "Api-Key k3y"}
        with connect(address, additional_headers=key) as first:
            first.recv(timeout=20)
            with (
                connect(address, additional_headers=key) as second,
                pytest.raises(ConnectionClosed, match="another client is connected"),
            ):
                second.recv(timeout=20)
            first.send(encode({"observation/state": STATES[0].astype(np.float32)}))
            assert isinstance(first.recv(timeout=20), bytes)
        with connect(address, additional_headers=key) as third:
            assert isinstance(third.recv(timeout=20), bytes)


@pytest.mark.parametrize("keys", [("prompt", "prompt"), ("wrist", "prompt")])
def test_state_prompt_and_pictures_have_a_name_each(keys: tuple[str, str]) -> None:
    skill = load_skill("bc-reach-cube")
    skill = skill.model_copy(update={"images": {"wrist": skill.images["eye"]}})
    with pytest.raises(ConfigError, match="^serve-policy: expected another name for state, "):
        PolicyServer(skill, OraclePolicy(8), keys, None, print)


WRONG: list[tuple[Any, str]] = [
    (b"\xc1", "serve-policy: no message: "),
    ("text", "serve-policy: expected a map, got str"),
    (encode({"state": 1}),
     "serve-policy: request: expected observation/state, prompt, got state"),
    (encode({"observation/state": np.zeros(29, np.float32)}),
     "serve-policy: expected observation/state as 30 finite numbers, got float32 [29]"),
    (encode({"observation/state": np.full(30, np.nan)}),
     "serve-policy: expected observation/state as 30 finite numbers, got nan at 0"),
    (encode({"observation/state": np.zeros(30), "prompt": None}),
     "serve-policy: expected prompt as text, got NoneType"),
]  # fmt: skip


def test_a_request_that_does_not_fit_is_answered_by_what_was_expected() -> None:
    with served(SKILL.id) as address:
        for request, text in WRONG:
            with connect(address) as link:
                link.recv(timeout=20)
                link.send(request)
                said = link.recv(timeout=20)
                assert isinstance(said, str) and said.startswith(f"PolicyError: {text}")
                with pytest.raises(ConnectionClosed):
                    link.recv(timeout=20)


class Slow(Misbehaving):
    """Infers until it is told to go on; ``calls`` are those that run now."""

    def __init__(self, skill: SkillManifest) -> None:
        super().__init__(skill)
        self.entered, self.go_on = threading.Semaphore(0), threading.Event()
        self.calls = self.most_calls = 0

    def infer(self, observation: Observation) -> np.ndarray:
        self.calls += 1
        self.most_calls = max(self.calls, self.most_calls)
        self.entered.release()
        self.go_on.wait(5.0)
        self.calls -= 1
        return np.zeros((1, 12), np.float32)


async def health(link: ClientConnection) -> bytes:
    """The first line of the answer to /healthz."""
    host, port = link.remote_address
    reader, writer = await asyncio.open_connection(host, port)
    writer.write(b"GET /healthz HTTP/1.1\r\nHost: test\r\n\r\n")
    line = await reader.readline()
    writer.close()
    return line


@pytest.mark.asyncio
async def test_a_server_whose_policy_infers_is_healthy_answers_pings_and_refuses_others() -> None:
    policy = Slow(SKILL)
    async with connected(policy, []) as link:
        await link.send(encode({KEYS[0]: STATES[0]}))
        assert await asyncio.to_thread(policy.entered.acquire, timeout=20)
        assert await health(link) == b"HTTP/1.1 200 OK\r\n"
        await (await link.ping())
        async with connect_async(f"ws://127.0.0.1:{link.remote_address[1]}") as other:
            with pytest.raises(ConnectionClosed, match="another client is connected"):
                await other.recv()
        assert policy.calls == 1, "it still infers"
        policy.go_on.set()
        assert isinstance(await link.recv(), bytes)


@pytest.mark.asyncio
async def test_who_comes_after_one_that_hung_up_within_its_inference_waits_for_the_end_of_it() -> (
    None
):
    policy = Slow(SKILL)
    async with connected(policy, []) as link:
        await link.send(encode({KEYS[0]: STATES[0]}))
        assert await asyncio.to_thread(policy.entered.acquire, timeout=20)
        await link.close()
        async with connect_async(f"ws://127.0.0.1:{link.remote_address[1]}") as other:
            assert policy.calls == 1, "it still infers"
            policy.go_on.set()
            assert isinstance(await other.recv(), bytes)
            await other.send(encode({KEYS[0]: STATES[0]}))
            assert isinstance(await other.recv(), bytes)
    assert policy.most_calls == 1


@asynccontextmanager
async def connected(policy: Policy, said: list[str]) -> AsyncIterator[ClientConnection]:
    """A client of a server in this process, greeted."""
    server = PolicyServer(SKILL, policy, KEYS, None, said.append)
    async with await server.listen("127.0.0.1", 0) as listening:
        port = next(iter(listening.sockets)).getsockname()[1]
        async with connect_async(f"ws://127.0.0.1:{port}") as link:
            await link.recv()
            yield link


@pytest.mark.asyncio
async def test_rows_as_lists_are_served_as_the_runner_takes_them() -> None:
    async with connected(Lists(SKILL), []) as link:
        await link.send(encode({KEYS[0]: STATES[0]}))
        answer = await link.recv()
        assert isinstance(answer, bytes)
        said = decode(answer)
    assert isinstance(said, dict)
    rows = said["actions"]
    np.testing.assert_array_equal(rows, np.full((2, 12), np.float32(0.1)))


@pytest.mark.parametrize(
    ("policy", "text"),
    [
        (Raises, "ValueError: no such token"),
        (Spells, "ValueError: no \\udc80"),
        (Exits, "SystemExit: no token"),
        (Wordless, "FaultError: its text cannot be had: ValueError"),
    ],
)
@pytest.mark.asyncio
async def test_a_policy_that_breaks_is_told_to_its_client_and_whole_in_the_log(
    policy: type[Misbehaving], text: str
) -> None:
    said: list[str] = []
    async with connected(policy(SKILL), said) as link:
        await link.send(encode({KEYS[0]: STATES[0]}))
        assert await link.recv() == text
    assert "Traceback" in said[-1]


def test_a_policy_that_cannot_be_loaded_is_one_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    (tmp_path / "mine").mkdir()
    for file, text in skill_skeleton("mine", load_robot("panda_mobile")).items():
        broken = text.replace("cls(float", "cls(flout")
        tmp_path.joinpath("mine", file).write_text(broken, encoding="utf-8")
    done = fairlead_here("serve-policy", "mine", state=tmp_path)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == (
        "ERROR serve-policy: skill mine: loading failed: NameError: name 'flout' is not defined"
    )
