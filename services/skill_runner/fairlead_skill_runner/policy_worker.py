"""The runner's end of the policy process: start it, ask it, end it; never wait for ever."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from multiprocessing.connection import Connection

from pydantic import JsonValue

from fairlead.errors import PolicyError
from fairlead.plugins import Plugin
from fairlead.policy import Actions, Done, Failed, Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policy_wire import (
    Answer,
    Ended,
    Infer,
    Load,
    Raised,
    Request,
    Reset,
    check_actions,
    decode_reply,
    encode,
)

LOAD_TIMEOUT_S = 120.0
RESET_TIMEOUT_S = LOAD_TIMEOUT_S  # a server that was started anew compiles
_END_TIMEOUT_S = 1.0
_ENDED_CHECK_S = 0.1


class PolicyWorker:
    """One policy in one process. Every call may block; calls of two threads take turns.

    After a `PolicyError` the process is gone, so a late answer cannot be taken for the
    answer to a later question; `load` starts a new one.
    """

    def __init__(
        self,
        policy: Plugin,
        skill: SkillManifest,
        options: Mapping[str, JsonValue],
        robot: str = "",
        profile: str = "",
    ) -> None:
        self._load = Load(
            policy, skill.model_dump_json(), json.dumps(dict(options)), robot, profile
        )
        self._skill = skill
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection | None = None
        self._turn = threading.Lock()

    @property
    def pid(self) -> int | None:
        """Process id while it runs."""
        return self._process.pid if self._process else None

    def load(self, ended: threading.Event | None = None, timeout_s: float = LOAD_TIMEOUT_S) -> None:
        """Start the process and load the policy, unless that has been done.

        Args:
            ended: set when nobody waits for it any more.

        Raises:
            PolicyError: if it cannot be loaded in time, or nobody waits any more.
        """
        with self._turn:
            if self._process is None or self._process.poll() is not None:
                self._start(timeout_s, ended)

    def _start(self, timeout_s: float, ended: threading.Event | None) -> None:
        self._end()
        ours, theirs = socket.socketpair()
        command = [sys.executable, "-m", "fairlead_skill_runner.policy_process"]
        self._process = subprocess.Popen(
            [*command, str(theirs.fileno())], pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL
        )
        theirs.close()
        self._connection = Connection(ours.detach())
        self._ask(self._load, "loading", timeout_s, ended)

    def reset(self, ended: threading.Event | None = None) -> None:
        """Tell the policy that a new goal begins; ``ended`` as in `load`.

        Raises:
            PolicyError: if it fails or takes too long, or nobody waits any more.
        """
        with self._turn:
            self._ask(Reset(), "reset", RESET_TIMEOUT_S, ended)

    def infer(self, observation: Observation) -> Actions | Done | Failed:
        """Ask for rows, float32 ``[H, dim]``, finite, H at most the skill's horizon, or an end.

        Raises:
            PolicyError: if the policy fails, takes longer than the skill's
                ``inference_timeout_s``, or returns anything else.
        """
        skill = self._skill
        with self._turn:
            answer = self._ask(Infer.of(observation), "inference", skill.inference_timeout_s)
            if isinstance(answer, Ended):
                return answer.end()
            try:
                return check_actions(answer, skill.action_contract.dim, skill.horizon)
            except PolicyError:
                self._kill()
                raise

    def close(self) -> None:
        """End the process; a call that is still running fails."""
        if not self._turn.acquire(timeout=_END_TIMEOUT_S):
            if self._process is not None:
                self._process.kill()
            self._turn.acquire()
        self._end()
        self._turn.release()

    def _end(self) -> None:
        """By force if it does not listen."""
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            try:
                self._process.wait(_END_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._process = self._connection = None

    def _ask(
        self, request: Request, what: str, timeout_s: float, ended: threading.Event | None = None
    ) -> Answer | Ended:
        if self._connection is None:
            raise PolicyError(f"policy worker: {what} asked, but no policy is loaded")
        try:
            self._connection.send_bytes(encode(request))
            until_s = time.monotonic() + timeout_s
            while not self._connection.poll(min(_ENDED_CHECK_S, timeout_s)):
                if ended is not None and ended.is_set():
                    self._kill()
                    raise PolicyError(f"policy worker: {what}: the goal was ended meanwhile")
                if time.monotonic() >= until_s:
                    self._kill()
                    raise PolicyError(f"policy worker: {what} took longer than {timeout_s:g} s")
            reply = decode_reply(self._connection.recv_bytes())
        except (OSError, EOFError):
            raise PolicyError(f"policy worker: {what}: {self._how_it_ended()}") from None
        if isinstance(reply, Raised):
            self._kill()
            raise PolicyError(f"policy worker: {what} failed: {reply.text}")
        return reply

    def _kill(self) -> None:
        if self._process is not None:
            self._process.kill()
        self._end()

    def _how_it_ended(self) -> str:
        process = self._process
        self._end()
        return f"the process ended with status {process.returncode if process else None}"
