"""A policy behind an RLDX (or GR00T) server: ZeroMQ request and reply, one at a time."""

from __future__ import annotations

import secrets
import socket
from collections.abc import Mapping
from typing import Self

import numpy as np
import zmq
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.policy import Actions, Observation, ServerAddress
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.action_rows import float_rows
from fairlead_skill_runner.policies.remote.rldx_wire import decode, encode
from fairlead_skill_runner.policies.remote.served_policy import (
    NO_MESSAGE,
    RemoteOptions,
    busy_server,
    check_remote_options,
    no_server,
    output_of,
    warm_up_observation,
)

WHO = "rldx policy"
ADDRESS = ServerAddress(r"^tcp://[^/\s:]+:\d+$", "tcp://127.0.0.1:5555")


class NamedAction(BaseModel):
    """One of the server's outputs."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    width: int = Field(gt=0)


class RldxOptions(RemoteOptions):
    """How state and actions are called on the wire.

    Attributes:
        language_key: of the prompt.
        state: name -> first and last index in the layout's vector, both included.
        actions: names in the order of the action vector.
    """

    address: str = Field(pattern=ADDRESS.pattern)
    language_key: str
    state: dict[str, tuple[int, int]] = Field(min_length=1)
    actions: tuple[NamedAction, ...] = Field(min_length=1)


class RldxZmqPolicy:
    """Asks the server and puts its named outputs in order.

    A socket on which something went wrong is closed, so that an answer that comes late
    has nowhere to come to.
    """

    def __init__(self, skill: SkillManifest, options: RldxOptions) -> None:
        self._skill, self._options = skill, options
        self._socket: zmq.Socket[bytes] | None = None
        self._monitor: zmq.Socket[bytes] | None = None
        self._session, self._first = secrets.token_hex(8), True

    server_address = ADDRESS

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises `ConfigError` for options that do not fit, alone or with the skill."""
        check_rldx_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Find the server, and let it compile.

        Raises:
            ConfigError: for options that do not fit.
            PolicyError: if no server is there, or it answers with other widths.
        """
        checked = check_rldx_options(skill, options)
        policy = cls(skill, checked)
        policy.reset()
        policy._warm_up()
        return policy

    def reset(self) -> None:
        """A socket and a session of its own for every episode; proves that a server is there.

        One that was started anew since the last episode compiles again, now and not under a
        claim.

        Raises:
            PolicyError: if none is.
        """
        before = self._socket, self._monitor
        self._socket = self._monitor = None
        try:
            self._dial()
            # Asked once the new connection has answered: the one thread that serves both has then
            # seen what became of the old one. ZeroMQ itself dials anew silently.
            was_ended = before[1] is not None and bool(before[1].poll(0))
        finally:
            _close(*before)
        if was_ended:
            self._warm_up()
        self._session, self._first = secrets.token_hex(8), True

    def _warm_up(self) -> None:
        self._act(warm_up_observation(self._skill), self._options.warm_up_timeout_s)

    def _dial(self) -> None:
        self._socket = zmq.Context.instance().socket(zmq.REQ)
        self._monitor = self._socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.connect(self._options.address)
        try:
            self._call({"endpoint": "ping"}, self._options.connect_timeout_s)
        except TimeoutError as error:
            if _listens(self._options.address):
                raise busy_server(WHO, self._skill, self._options, "no answer to a ping") from None
            raise no_server(WHO, self._skill, self._options, error) from None

    def infer(self, observation: Observation) -> Actions:
        """The server's rows.

        Raises:
            PolicyError: if it fails, is late, goes away or answers anything else.
        """
        return self._act(observation, self._options.answer_timeout_s)

    def _act(self, observation: Observation, timeout_s: float) -> Actions:
        data = {
            "observation": self._flat(observation),
            "options": {"session_ids": [self._session], "reset_memory": [self._first]},
        }
        try:
            reply = self._call({"endpoint": "get_action", "data": data}, timeout_s)
        except TimeoutError as error:
            raise PolicyError(f"{WHO}: {self._options.address}: {error}") from None
        self._first = False
        try:
            return self._rows(reply)
        except PolicyError:
            self._close()
            raise

    def _flat(self, observation: Observation) -> dict[str, object]:
        """Arrays are [batch 1, time 1, ...]."""
        state = observation.state.astype("<f4")
        return {
            **{f"video.{name}": image[None, None] for name, image in observation.images.items()},
            **{
                f"state.{name}": state[None, None, first : last + 1]
                for name, (first, last) in self._options.state.items()
            },
            self._options.language_key: [observation.prompt],
        }

    def _rows(self, reply: object) -> Actions:
        """``[{"action.<name>": [1, H, width], ...}, information]`` as ``[H, dim]``."""
        named = reply[0] if isinstance(reply, list) and reply else None
        if not isinstance(named, dict):
            raise PolicyError(expected(WHO, "a list that begins with a map", type(reply).__name__))
        blocks = []
        for action in self._options.actions:
            value = output_of(WHO, named, f"action.{action.name}")
            if isinstance(value, np.ndarray) and value.ndim == 3 and len(value) == 1:
                value = value[0]
            rows = float_rows(
                WHO, f"action.{action.name}", value, action.width, self._skill.horizon
            )
            blocks.append(rows)
        if len({len(block) for block in blocks}) != 1:
            lengths = ", ".join(str(len(block)) for block in blocks)
            raise PolicyError(expected(WHO, "as many rows of every action", lengths))
        return np.concatenate(blocks, axis=1)

    def _call(self, request: dict[str, object], timeout_s: float) -> object:
        """One exchange; after any failure there is no socket any more.

        Raises:
            PolicyError: for an answer that is an error or no message.
            TimeoutError: for none.
        """
        if self._socket is None:
            raise PolicyError(f"{WHO}: asked without a connection")
        self._socket.send(encode(request))
        if not self._socket.poll(int(timeout_s * 1000)):
            self._close()
            raise TimeoutError(f"no answer within {timeout_s:g} s")
        try:
            reply = decode(self._socket.recv())
        except NO_MESSAGE as error:
            self._close()
            raise PolicyError(
                f"{WHO}: {self._options.address} answered no message: {error}"
            ) from None
        if isinstance(reply, dict) and "error" in reply:
            self._close()
            raise PolicyError(f"{WHO}: {self._options.address} failed: {reply['error']}")
        return reply

    def _close(self) -> None:
        _close(self._socket, self._monitor)
        self._socket = self._monitor = None


def _close(link: zmq.Socket[bytes] | None, monitor: zmq.Socket[bytes] | None) -> None:
    if link is not None:
        link.disable_monitor()
        link.close(linger=0)
    if monitor is not None:
        monitor.close(linger=0)


def _listens(address: str) -> bool:
    host, _, port = address.removeprefix("tcp://").rpartition(":")
    try:
        with socket.create_connection((host, int(port)), timeout=1.0):
            return True
    except OSError:
        return False


def check_rldx_options(skill: SkillManifest, options: Mapping[str, JsonValue]) -> RldxOptions:
    """The options of an RLDX policy.

    Raises:
        ConfigError: for options that do not fit, alone or with the skill's contracts.
    """
    checked = check_remote_options(WHO, RldxOptions, options, skill)
    _check_widths(checked, skill)
    return checked


def _check_widths(options: RldxOptions, skill: SkillManifest) -> None:
    """State and actions must be the skill's contracts, no more and no less."""
    width = sum(action.width for action in options.actions)
    if width != skill.action_contract.dim:
        raise ConfigError(
            expected(f"{WHO}: actions", f"{skill.action_contract.dim} numbers in all", width)
        )
    indices = sorted(i for first, last in options.state.values() for i in range(first, last + 1))
    dim = skill.state_contract.dim
    if indices != list(range(dim)):
        raise ConfigError(
            expected(f"{WHO}: state", f"every index of 0..{dim - 1} once", f"indices {indices}")
        )
