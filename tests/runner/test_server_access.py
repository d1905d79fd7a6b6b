"""Servers that want a key, greet oddly or fail: what is said, where, and what never is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from websockets.datastructures import Headers
from websockets.http11 import Response
from websockets.sync.server import ServerConnection

from fairlead.errors import ConfigError
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.remote.openpi import OpenpiPolicy
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from tests.runner.asked_policies import PI05, RLDX, ROWS, failure
from tests.runner.policy_servers import (
    ANSWERS,
    OpenpiServer,
    RldxServer,
    openpi_actions,
    rldx_actions,
    rldx_rows,
)

pytestmark = pytest.mark.processes

KEY = "s3cret-of-the-test"
VARIABLE = "FAIRLEAD_TEST_KEY"
POLICIES: dict[str, type[OpenpiPolicy | RldxZmqPolicy]] = {PI05: OpenpiPolicy, RLDX: RldxZmqPolicy}


@pytest.fixture(params=[PI05, RLDX])
def guarded(request: pytest.FixtureRequest, closing: list[Any]) -> tuple[str, str]:
    """A skill, and the address of a server of it that lets nobody in without the key."""
    server: OpenpiServer | RldxServer
    if request.param == RLDX:
        server = RldxServer(lambda request, n: rldx_actions(rldx_rows(ROWS)))
        server.api_token = KEY
    else:

        def guard(link: ServerConnection, asked: Any) -> Response | None:
            if asked.headers.get("Authorization") == f"Api-Key {KEY}":
                return None
            return Response(401, "Unauthorized", Headers())

        server = OpenpiServer(lambda request, n: openpi_actions(ROWS), guard=guard)
    closing.append(server)
    return request.param, server.address


def load(guarded: tuple[str, str], **options: str) -> None:
    skill_id, address = guarded
    skill = load_skill(skill_id)
    chosen = skill.policy.options | {"address": address} | options
    policy = POLICIES[skill_id].from_options(skill, chosen)
    if isinstance(policy, RldxZmqPolicy):
        policy._link.close()
    else:
        policy._close()


def test_a_key_comes_from_a_variable_or_a_file(
    guarded: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, KEY)
    load(guarded, api_key_env=VARIABLE)
    (tmp_path / "key").write_text(f"{KEY}\n")
    load(guarded, api_key_file=str(tmp_path / "key"))


def test_without_a_key_or_with_a_wrong_one_the_server_is_named_and_what_to_do_but_no_key(
    guarded: tuple[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    text = failure(lambda: load(guarded))
    assert f"{guarded[1]} lets nobody in without a key: " in text
    assert "it got no key: api_key_env: NAME (an environment variable) or api_key_file: PAT" in text
    monkeypatch.setenv(VARIABLE, "wr0ng")
    text += failure(lambda: load(guarded, api_key_env=VARIABLE))
    assert f"; the key it got is from the environment variable {VARIABLE}" in text
    captured = capfd.readouterr()
    assert "wr0ng" not in text + captured.out + captured.err


def test_a_key_that_is_none_is_said_before_the_server_is_asked(
    guarded: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    wanted = f"expected an API key in the environment variable {VARIABLE}, got nothing"
    assert wanted in failure(lambda: load(guarded, api_key_env=VARIABLE))
    (tmp_path / "key").write_text(f"{KEY}\nX-Other: header")
    text = failure(lambda: load(guarded, api_key_file=str(tmp_path / "key")))
    assert "got more than one line of text" in text
    assert KEY not in text
    text = failure(lambda: load(guarded, api_key_file=str(tmp_path / "absent")))
    assert "api_key_file: cannot be read: " in text


def test_only_one_place_for_the_key(guarded: tuple[str, str]) -> None:
    with pytest.raises(ConfigError, match="api_key_env, api_key_file: expected one of them"):
        load(guarded, api_key_env="A", api_key_file="b")


@pytest.mark.parametrize(
    ("greeting", "got"),
    [(b"\xc1", "bytes of 1 bytes"), (b"\x07", "int of 1 bytes")],
)
def test_something_that_greets_otherwise_is_no_openpi_server(
    closing: list[Any], greeting: bytes, got: str
) -> None:
    server = OpenpiServer(lambda request, n: openpi_actions(ROWS), greeting=greeting)
    closing.append(server)
    text = failure(lambda: load((PI05, server.address)))
    assert text == (
        f"openpi policy: expected openpi's metadata, a map, first from {server.address}, got {got}"
    )


def test_a_server_that_fails_as_it_greets_says_why(closing: list[Any]) -> None:
    said = "Traceback (most recent call last):\n  ...\nRuntimeError: CUDA out of memory"
    server = OpenpiServer(lambda request, n: openpi_actions(ROWS), greeting=said)
    closing.append(server)
    text = failure(lambda: load((PI05, server.address)))
    assert text == f"openpi policy: {server.address} failed: RuntimeError: CUDA out of memory"


def test_what_openpi_s_server_says_of_itself_and_answers_to_a_probe_is_in_the_log(
    openpi: Callable[[ANSWERS], OpenpiServer], capfd: pytest.CaptureFixture[str]
) -> None:
    server = openpi(lambda request, n: openpi_actions(ROWS))
    load((PI05, server.address))
    said = capfd.readouterr().err
    assert f"openpi policy: {server.address} tells of itself: who; asked with a probe " in said
    assert "it gave [4, 12] after " in said


def test_a_server_s_traceback_is_whole_in_the_log_and_a_wrong_name_is_said_beside_what_was_sent(
    openpi: Callable[[ANSWERS], OpenpiServer], capfd: pytest.CaptureFixture[str]
) -> None:
    whole = (
        'Traceback (most recent call last):\n  File "robocasa_policy.py", line 7, in __call__\n'
        "    return data[name]\nKeyError: 'observation/front'\n"
        "--------------------\nFor simplicity, JAX has removed its internal frames ...\n"
    )
    server = openpi(lambda request, n: whole)
    text = failure(lambda: load((PI05, server.address)))
    assert text.endswith(
        "failed: KeyError: 'observation/front'; it was sent observation/state, observation/image, "
        "observation/right_image, observation/wrist_image, prompt"
    )
    assert whole in capfd.readouterr().err


def test_metadata_may_be_empty(closing: list[Any], capfd: pytest.CaptureFixture[str]) -> None:
    server = OpenpiServer(
        lambda request, n: openpi_actions(ROWS), greeting=msgspec.msgpack.encode({})
    )
    closing.append(server)
    load((PI05, server.address))
    assert "tells of itself: nothing; asked with a probe" in capfd.readouterr().err


@pytest.mark.parametrize("location", ["https://127.0.0.1/x", "ws://[::zz/"])
def test_a_server_that_sends_elsewhere_than_to_a_policy_server_is_none(
    location: str, closing: list[Any]
) -> None:
    def moved(link: ServerConnection, asked: Any) -> Response:
        answer = Response(301, "Moved Permanently", Headers())
        answer.headers["Location"] = location
        return answer

    server = OpenpiServer(lambda request, n: None, guard=moved)
    closing.append(server)
    text = failure(lambda: load((PI05, server.address)))
    assert text.startswith(f"openpi policy: no policy server at {server.address}: ")
