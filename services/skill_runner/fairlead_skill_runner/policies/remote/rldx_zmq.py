"""A policy behind an RLDX or GR00T server that is started with its sim policy wrapper."""

from __future__ import annotations

import secrets
import time
from collections.abc import Mapping
from typing import Self

import numpy as np
from pydantic import JsonValue

from fairlead.errors import PolicyError, expected
from fairlead.policy import Actions, Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.action_rows import float_rows
from fairlead_skill_runner.policies.remote.modality_check import modality_problems
from fairlead_skill_runner.policies.remote.modality_config import (
    Dialect,
    ServerConfig,
    read_config,
)
from fairlead_skill_runner.policies.remote.rldx_options import (
    ADDRESS,
    RldxOptions,
    check_rldx_options,
)
from fairlead_skill_runner.policies.remote.served_policy import (
    output_of,
    say,
    warm_up_observation,
)
from fairlead_skill_runner.policies.remote.zmq_link import WHO, ServerError, ZmqLink

_PREFIX = "action_prefix"
_TOO_WIDE = np.zeros((1, 4096), np.float32)


class RldxZmqPolicy:
    """Asks the server and puts its named outputs in order.

    Attributes:
        continues_rows: its answers go on from `Observation.prefix`.
    """

    def __init__(self, skill: SkillManifest, options: RldxOptions) -> None:
        self._skill, self._options = skill, options
        self._link = ZmqLink(skill, options)
        self._session, self._first = secrets.token_hex(8), True
        self._server = ServerConfig(Dialect.CLASS, {})
        self._reads_prefix = False
        self.continues_rows = options.rtc

    server_address = ADDRESS

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises `ConfigError` for options that do not fit, alone or with the skill."""
        check_rldx_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Find the server, hold what it says of itself against the skill, let it compile.

        Raises:
            ConfigError: for options that do not fit.
            PolicyError: if no server is there, it wants or gives something else, or it answers
                with other widths.
        """
        policy = cls(skill, check_rldx_options(skill, options))
        policy._link.dial()
        policy._warm_up()
        return policy

    def reset(self) -> None:
        """A socket of its own for every episode, which proves that a server is there.

        The server forgets the last episode. One that was started anew since then is checked, and
        compiles, again: now and not under a claim.

        Raises:
            PolicyError: as `from_options`.
        """
        if not self._link.dial():
            self._warm_up()
        # The same session again: a server that keeps sessions has one of ours, not one a goal.
        self._first = True
        if self._server.dialect is not Dialect.N1_5:  # which has no such endpoint
            self._link.ask("reset", {"options": {"session_ids": [self._session]}})

    def _warm_up(self) -> None:
        try:
            self._check_config()
            begun_s = time.monotonic()
            rows = self._probe(warm_up_observation(self._skill))
            told = ", ".join(self._server.modalities) or "nothing"
            say(
                WHO,
                f"{self._options.address} speaks as {self._server.dialect.value}; it tells of its "
                f"modalities: {told}; asked with a probe observation it gave {list(rows.shape)} "
                f"after {time.monotonic() - begun_s:.2f} s",
            )
            self._check_rtc(rows)
        except PolicyError:
            self._link.close()
            raise

    def _probe(self, seen: Observation) -> Actions:
        """The rows for an observation. Also learns whether the server reads a prefix.

        Nothing that servers tell says it; but one that does refuses rows wider than its model's.
        """
        timeout_s, self._reads_prefix = self._options.warm_up_timeout_s, False
        try:
            return self._act(seen, timeout_s, _TOO_WIDE)
        except ServerError as error:
            if _PREFIX not in error.said:
                raise
        self._reads_prefix = True
        return self._act(seen, timeout_s, self._prefix(seen))

    def _check_rtc(self, rows: Actions) -> None:
        """With ``rtc`` a server must go on from rows that it is given: the probe's first one."""
        address = self._options.address
        if not self._options.rtc:
            if self._reads_prefix:
                # else it goes on from its own last answer, whatever the gate released of it
                say(WHO, f"{address}: every request switches its real-time chunking off: no rtc")
            return
        if not self._reads_prefix:
            raise PolicyError(
                f"{WHO}: rtc: {address} takes no prefix: start RLDX-1's server with "
                "--rtc-inference-mode and --rtc-inference-delay, or leave rtc out"
            )
        if "action" not in self._server.modalities:
            wanted = "a server that tells the order of its actions"
            raise PolicyError(expected(f"{WHO}: rtc", wanted, "none told"))
        prefix, seen = self._in_its_order(rows[:1]), warm_up_observation(self._skill)
        again = self._act(seen, self._options.warm_up_timeout_s, prefix)
        apart = np.abs(self._in_its_order(again[:1]) - prefix).max()
        say(WHO, f"{address} goes on from a prefix of one row within {apart:.2g} of it")

    def _check_config(self) -> None:
        self._link.arrays = "npy"
        answer = self._link.ask("get_modality_config")
        self._server = read_config(WHO, {} if answer is None else answer)
        self._link.arrays = self._server.dialect.arrays
        options = self._options
        problems = modality_problems(
            self._server.modalities,
            self._skill,
            options.state,
            [action.name for action in options.actions],
            options.language_key,
        )
        if problems:
            listed = "\n  ".join(problems)
            raise PolicyError(
                f"{WHO}: {options.address} does not serve this skill's policy:\n  {listed}"
            )

    def infer(self, observation: Observation) -> Actions:
        """The server's rows.

        Raises:
            PolicyError: if it fails, is late, goes away or answers anything else.
        """
        prefix = self._prefix(observation) if self._reads_prefix else None
        return self._act(observation, self._options.answer_timeout_s, prefix)

    def _prefix(self, observation: Observation) -> Actions:
        """``[n, dim]``; of no rows without ``rtc``, which switches it off."""
        rows = observation.prefix() if self._options.rtc else np.zeros((0, 0), np.float32)
        return self._in_its_order(rows.reshape(-1, self._skill.action_contract.dim))

    def _in_its_order(self, rows: Actions) -> Actions:
        """Rows with the server's columns: it has an order of its own, and tells it."""
        starts = np.cumsum([0, *(action.width for action in self._options.actions)])
        columns = {
            action.name: np.arange(start, start + action.width)
            for action, start in zip(self._options.actions, starts[:-1], strict=True)
        }
        told = self._server.modalities.get("action")
        names = columns if told is None else told.modality_keys
        ordered: Actions = rows[:, np.concatenate([columns[name] for name in names])]
        return ordered

    def _act(self, observation: Observation, timeout_s: float, prefix: Actions | None) -> Actions:
        """prefix: ``[n, width]`` in the server's units and order; None: not a word of it."""
        data: dict[str, object] = self._flat(observation)
        if self._server.dialect is not Dialect.N1_5:
            options = {"session_ids": [self._session], "reset_memory": [self._first]}
            if prefix is not None:
                options |= {_PREFIX: prefix[None], "rtc_prefix_len": len(prefix)}
            data = {"observation": data, "options": options}
        try:
            request = {"endpoint": "get_action", "data": data}
            reply = self._link.call(request, timeout_s, keep=_PREFIX)
        except TimeoutError as error:
            raise PolicyError(f"{WHO}: {self._options.address}: {error}") from None
        self._first = False
        try:
            return self._rows(reply)
        except PolicyError:
            self._link.close()
            raise

    def _flat(self, observation: Observation) -> dict[str, object]:
        """Arrays are [batch 1, time, ...], for GR00T N1.5 [time, ...]."""
        batch = () if self._server.dialect is Dialect.N1_5 else (None,)
        state = observation.state.astype("<f4")
        return {
            **{
                f"video.{name}": observation.frames_of(name)[(*batch, ...)]
                for name in observation.images
            },
            **{
                f"state.{name}": state[(*batch, None, slice(first, last + 1))]
                for name, (first, last) in self._options.state.items()
            },
            self._options.language_key: [observation.prompt],
        }

    def _rows(self, reply: object) -> Actions:
        """``[{"action.<name>": [1, H, width], ...}, information]`` as ``[H, dim]``.

        GR00T N1.5 answers with the map alone, and without the batch axis.
        """
        named = reply[0] if isinstance(reply, list) and reply else None
        if self._server.dialect is Dialect.N1_5:
            named = reply
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
