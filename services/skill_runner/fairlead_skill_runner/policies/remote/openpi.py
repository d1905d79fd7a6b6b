"""A policy behind an openpi server: one question, one answer, over a websocket."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from typing import Self

from pydantic import Field, JsonValue
from websockets.exceptions import ConnectionClosed, InvalidStatus, WebSocketException
from websockets.sync.client import ClientConnection, connect

from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.policy import Actions, Observation, ServerAddress
from fairlead.skill.deltas import NOW
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.action_rows import float_rows
from fairlead_skill_runner.policies.remote.openpi_wire import decode, encode
from fairlead_skill_runner.policies.remote.served_policy import (
    NO_MESSAGE,
    SIGN_OF_LIFE_S,
    RemoteOptions,
    busy_server,
    check_remote_options,
    no_server,
    output_of,
    refused_key,
    require_names,
    say,
    server_failed,
    taken_server,
    warm_up_observation,
)
from fairlead_skill_runner.policies.remote.served_skill import check_served

WHO = "openpi policy"
ADDRESS = ServerAddress(r"^wss?://[^/\s]+(/\S*)?$", "ws://127.0.0.1:8000")
_MESSAGE_MAX_BYTES = 64 * 2**20
_CLOSE_TIMEOUT_S = 0.2
_NO_ACCESS = (401, 403)
_LATER = 1013
"""How a websocket is closed by a server that has no room for another client."""


class OpenpiOptions(RemoteOptions):
    """How the server calls things, and itself.

    Attributes:
        state_key, prompt_key: their names in the request; pictures have the skill's names.
        serves: the skill whose policy ``fairlead serve-policy`` serves there, if it has another
            id than the one that asks.
    """

    address: str = Field(pattern=ADDRESS.pattern)
    state_key: str = "observation/state"
    prompt_key: str = "prompt"
    serves: str = ""


class OpenpiPolicy:
    """Asks the server and checks what comes back.

    A connection on which something went wrong is closed, so that an answer that comes
    late has nowhere to come to.
    """

    def __init__(self, skill: SkillManifest, options: OpenpiOptions) -> None:
        self._skill = skill
        self._options = options
        self._link: ClientConnection | None = None
        self._open = ExitStack()
        self._metadata: list[str] = []

    server_address = ADDRESS

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises `ConfigError` for options that do not fit, alone or with the skill."""
        check_openpi_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Connect, and let the server compile.

        Raises:
            ConfigError: for options that do not fit.
            PolicyError: if no server is there, it says that it serves another skill, or it answers
                with another width.
        """
        policy = cls(skill, check_openpi_options(skill, options))
        policy._dial()
        policy._warm_up()
        return policy

    def reset(self) -> None:
        """A connection of its own for every episode, which also proves that a server is there.

        One that was started anew since the last episode compiles again, now and not under a
        claim.

        Raises:
            PolicyError: if none is.
        """
        is_the_same = self._is_the_same()
        self._close()
        self._dial()
        if not is_the_same:
            self._warm_up()
            self._close()  # a server may remember what a connection has shown it
            self._dial()

    def _is_the_same(self) -> bool:
        """Whether the server still answers where the last episode was.

        A host that loses its power ends no connection.
        """
        with suppress(ConnectionClosed, OSError):
            return self._link is not None and self._link.ping().wait(SIGN_OF_LIFE_S)
        return False

    def _warm_up(self) -> None:
        """The server does not say what it wants and gives: one black observation shows it."""
        begun_s = time.monotonic()
        rows = self._ask(warm_up_observation(self._skill), self._options.warm_up_timeout_s)
        took_s = time.monotonic() - begun_s
        say(
            WHO,
            f"{self._options.address} tells of itself: {', '.join(self._metadata) or 'nothing'}; "
            f"asked with a probe observation it gave {list(rows.shape)} after {took_s:.2f} s",
        )

    def _dial(self) -> None:
        options, awaited = self._options, "no websocket handshake"
        try:
            key = options.api_key(WHO)
            # A server that infers answers no keep-alive; the deadlines are ours.
            dialled = connect(
                options.address,
                open_timeout=options.connect_timeout_s,
                close_timeout=_CLOSE_TIMEOUT_S,
                ping_interval=None,
                compression=None,
                max_size=_MESSAGE_MAX_BYTES,
                proxy=None,
                additional_headers={"Authorization": f"Api-Key {key}"} if key else None,
            )
            self._link = self._open.enter_context(dialled)
            awaited = "no greeting (openpi's metadata)"
            self._greeted(self._link.recv(timeout=options.connect_timeout_s))
        except TimeoutError:
            self._close()
            raise busy_server(WHO, self._skill, options, awaited) from None
        except PolicyError:
            self._close()
            raise
        except (OSError, WebSocketException, ValueError) as error:
            self._close()  # a ValueError is of where a redirect leads
            if isinstance(error, ConnectionClosed) and error.rcvd and error.rcvd.code == _LATER:
                raise taken_server(WHO, options, error.rcvd.reason) from None
            if isinstance(error, InvalidStatus) and error.response.status_code in _NO_ACCESS:
                raise refused_key(WHO, options, str(error)) from None
            raise no_server(WHO, self._skill, options, error) from None

    def _greeted(self, greeting: str | bytes) -> None:
        """What the server says of itself first: its configuration's metadata, often nothing."""
        try:
            metadata = greeting if isinstance(greeting, str) else decode(greeting)
        except NO_MESSAGE:
            metadata = greeting
        if isinstance(metadata, str):  # as openpi says that something failed
            raise PolicyError(server_failed(WHO, self._options.address, metadata))
        if not isinstance(metadata, dict):
            got = f"{type(metadata).__name__} of {len(greeting)} bytes"
            what = f"openpi's metadata, a map, first from {self._options.address}"
            raise PolicyError(expected(WHO, what, got))
        options = self._options
        check_served(WHO, options.address, metadata, self._skill, options.serves)
        self._metadata = list(map(str, metadata))

    def infer(self, observation: Observation) -> Actions:
        """The server's rows.

        Raises:
            PolicyError: if it fails, is late, goes away or answers anything else.
        """
        return self._ask(observation, self._options.answer_timeout_s)

    def _ask(self, observation: Observation, timeout_s: float) -> Actions:
        try:
            answer = self._exchange(encode(self._request(observation)), timeout_s)
            if not isinstance(answer, dict):
                raise PolicyError(expected(WHO, "a map with actions", type(answer).__name__))
            skill = self._skill
            rows = output_of(WHO, answer, "actions")
            return float_rows(WHO, "actions", rows, skill.action_contract.dim, skill.horizon)
        except PolicyError:
            self._close()
            raise

    def _request(self, observation: Observation) -> dict[str, object]:
        return {
            self._options.state_key: observation.state.astype("<f4"),
            **observation.images,
            self._options.prompt_key: observation.prompt,
        }

    def _exchange(self, request: bytes, timeout_s: float) -> object:
        if self._link is None:
            raise PolicyError(f"{WHO}: asked without a connection")
        address = self._options.address
        try:
            self._hear_nothing(self._link, address)
            self._link.send(request)
            reply = self._link.recv(timeout=timeout_s)
        except TimeoutError:
            raise PolicyError(f"{WHO}: no answer from {address} within {timeout_s:g} s") from None
        except (ConnectionClosed, OSError) as error:
            raise PolicyError(f"{WHO}: {address} closed the connection: {error}") from None
        if isinstance(reply, str):  # a traceback
            failed = server_failed(WHO, address, reply)
            names = [self._options.state_key, *self._skill.images, self._options.prompt_key]
            hint = f"; it was sent {', '.join(names)}" if "failed: KeyError" in failed else ""
            raise PolicyError(f"{failed}{hint}")
        try:
            return decode(reply)
        except NO_MESSAGE as error:
            raise PolicyError(f"{WHO}: {address} answered no message: {error}") from None

    def _hear_nothing(self, link: ClientConnection, address: str) -> None:
        """Before a question: an answer too many would be taken for its own."""
        with suppress(TimeoutError):
            link.recv(timeout=0)
            raise PolicyError(f"{WHO}: {address} sent a message that nobody asked for")

    def _close(self) -> None:
        self._open.close()
        self._link = None


def check_openpi_options(skill: SkillManifest, options: Mapping[str, JsonValue]) -> OpenpiOptions:
    """The options of an openpi policy.

    Raises:
        ConfigError: for options that do not fit, alone or with the skill.
    """
    checked = check_remote_options(WHO, OpenpiOptions, options, skill)
    for name, image in skill.images.items():
        if image.deltas != NOW:
            what = f"images.{name}: deltas {list(NOW)}, as openpi takes one frame of each picture"
            raise ConfigError(expected(WHO, what, list(image.deltas)))
    require_names(WHO, skill, checked.state_key, checked.prompt_key)
    return checked
