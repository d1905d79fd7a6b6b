"""Any skill's policy behind the openpi protocol: a greeting, then one answer a request.

A request is a map with the state, the prompt and the skill's pictures under their names; the
answer has ``actions``, float32 ``[H, dim]``. The protocol knows no episodes and no ticks: a
connection is one episode, and each request is ``execute_steps`` rows after the one before. The
policy infers in a thread, so the server hears and answers all else meanwhile.
"""

from __future__ import annotations

import asyncio
import hmac
from collections.abc import Callable, Mapping
from contextlib import suppress
from http import HTTPStatus
from traceback import format_exc
from typing import Any

import numpy as np
import numpy.typing as npt
from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.protocol import State

from fairlead.errors import PolicyError, expected
from fairlead.messages import FloatArray
from fairlead.plugins import POLICIES
from fairlead.policy import Done, Failed, Observation, Policy
from fairlead.reason_text import reason_of
from fairlead.robot.manifest import load_robot
from fairlead.skill.image_spec import ImageSpec
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.state_contract import StateContract
from fairlead_skill_runner.action_rows import policy_rows
from fairlead_skill_runner.policies.backends import make_policy
from fairlead_skill_runner.policies.remote.openpi_wire import decode, encode
from fairlead_skill_runner.policies.remote.served_policy import NO_MESSAGE, require_names
from fairlead_skill_runner.policies.remote.served_skill import KEY, told_of

_MESSAGE_MAX_BYTES = 64 * 2**20
_FAILED, _LATER = 1011, 1013
_GONE_S = 180.0
"""A client that answers no ping is gone; the first inference may take a while to compile."""


class PolicyServer:
    """One policy and at most one client at a time: what a policy remembers is one episode's.

    Args:
        keys: the names of state and prompt in a request.
        api_key: what a client has to send; None lets all in.
        say: told of clients that come and of requests that are refused.

    Raises:
        ConfigError: two of the names are one.
    """

    def __init__(
        self,
        skill: SkillManifest,
        policy: Policy,
        keys: tuple[str, str],
        api_key: str | None,
        say: Callable[[str], None],
    ) -> None:
        require_names("serve-policy", skill, *keys)
        self._skill, self._policy, self._say = skill, policy, say
        self._state_key, self._prompt_key = keys
        self._api_key = api_key
        self._newest: ServerConnection | None = None
        self._turn = asyncio.Lock()

    async def listen(self, host: str, port: int) -> Server:
        """Begin to serve; port 0 takes any that is free."""
        return await serve(
            self._client, host, port, compression=None, max_size=_MESSAGE_MAX_BYTES,
            ping_timeout=_GONE_S, process_request=self._admit,
        )  # fmt: skip

    def _admit(self, link: ServerConnection, asked: Request) -> Response | None:
        if asked.path == "/healthz":  # as openpi's own
            return link.respond(HTTPStatus.OK, "OK\n")
        given = ", ".join(asked.headers.get_all("Authorization"))  # several are none
        if self._api_key is not None and not hmac.compare_digest(
            given.encode(), f"Api-Key {self._api_key}".encode()
        ):
            return link.respond(HTTPStatus.UNAUTHORIZED, "expected the server's API key\n")
        return None

    async def _client(self, link: ServerConnection) -> None:
        if self._newest is not None and self._newest.state is State.OPEN:
            self._say(f"{link.remote_address}: refused, another client is connected")
            await link.close(_LATER, "another client is connected")
            return
        self._newest = link
        async with self._turn:  # one that hung up may still be inferred for
            await self._episode(link)

    async def _episode(self, link: ServerConnection) -> None:
        try:
            await asyncio.to_thread(self._policy.reset)
            await link.send(encode({KEY: told_of(self._skill)}))
            self._say(f"{link.remote_address}: connected")
            tick = 1
            async for message in link:
                await link.send(await asyncio.to_thread(self._answer, message, tick))
                tick += self._skill.execute_steps
        except ConnectionClosed:
            pass
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a policy may raise anything; both are told
            known, said = isinstance(error, PolicyError), reason_of(error)
            self._say(f"{link.remote_address}: {said if known else format_exc().rstrip()}")
            with suppress(ConnectionClosed):
                await link.send(f"PolicyError: {said}" if known else said)  # as openpi, then ends
                await link.close(_FAILED)

    def _answer(self, message: str | bytes, tick: int) -> bytes:
        try:
            request = decode(message) if isinstance(message, bytes) else message
        except NO_MESSAGE as error:
            raise PolicyError(f"serve-policy: no message: {error}") from None
        if not isinstance(request, dict):
            raise PolicyError(expected("serve-policy", "a map", type(request).__name__))
        answer = self._policy.infer(self._observation(request, tick))
        if isinstance(answer, Done | Failed):
            raise PolicyError(f"serve-policy: the policy ended its goal: {answer.reason}")
        rows = policy_rows(answer, self._skill.action_contract.dim, self._skill.horizon)
        return encode({"actions": rows})

    def _observation(self, request: Mapping[Any, object], tick: int) -> Observation:
        wanted = [self._state_key, self._prompt_key, *self._skill.images]
        absent = [name for name in wanted if name not in request and name != self._prompt_key]
        if absent or set(request) - set(wanted):
            got = ", ".join(map(str, request))
            raise PolicyError(expected("serve-policy: request", ", ".join(wanted), got))
        images, frames = {}, {}
        for name, spec in self._skill.images.items():
            pixels = _pixels(name, request[name], spec)
            images[name] = pixels if len(spec.deltas) == 1 else pixels[-1]
            if len(spec.deltas) > 1:
                frames[name] = pixels
        states = _states(self._state_key, request[self._state_key], self._skill.state_contract)
        prompt = request.get(self._prompt_key, self._skill.prompt)
        if not isinstance(prompt, str):
            raise PolicyError(
                expected("serve-policy", f"{self._prompt_key} as text", _kind(prompt))
            )
        return Observation(tick, states[-1], prompt, images, frames=frames, earlier=states[:-1])


def _states(name: str, value: object, contract: StateContract) -> FloatArray:
    times = (len(contract.deltas),) if len(contract.deltas) > 1 else ()
    shape = (*times, contract.dim)
    if isinstance(value, np.ndarray) and value.dtype.kind in "fiu" and value.shape == shape:
        numbers = value.astype(np.float64)
        if np.isfinite(numbers).all():
            return numbers.reshape(-1, contract.dim)
        fault = int(np.flatnonzero(~np.isfinite(numbers))[0])
        got = f"{numbers.flat[fault]} at {fault}"
    else:
        got = _kind(value)
    wanted = f"{name} as {' x '.join(map(str, shape))} finite numbers"
    raise PolicyError(expected("serve-policy", wanted, got))


def _pixels(name: str, value: object, spec: ImageSpec) -> npt.NDArray[Any]:
    """The client's picture as the skill declares it: nothing is done to it here."""
    times = (len(spec.deltas),) if len(spec.deltas) > 1 else ()
    kind, shape = spec.number_type, (*times, *spec.shape)
    if isinstance(value, np.ndarray) and value.dtype == kind and value.shape == shape:
        return value
    raise PolicyError(expected("serve-policy", f"{name} as {kind} {list(shape)}", _kind(value)))


def _kind(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {list(value.shape)}"
    return type(value).__name__


def served_policy(skill: SkillManifest) -> Policy:
    """The skill's policy, in this process.

    Raises:
        ConfigError, PolicyError: it cannot be loaded.
    """
    backend, options = POLICIES.find(skill.policy.backend), skill.policy.options
    robot = skill.embodiments[0]
    return make_policy(backend, skill, options, lambda: load_robot(robot), "sim")
