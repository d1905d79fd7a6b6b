"""The runner's end of the policy process: start it, ask it, end it; never wait for ever."""

from __future__ import annotations

import asyncio
import json
import logging
import os
import signal
import socket
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from pydantic import JsonValue

from fairlead.errors import PolicyError
from fairlead.plugins import Plugin
from fairlead.policy import Actions, Done, Failed, Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policy_wire import (
    HEADER,
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
    reply_max_bytes,
)

LOAD_TIMEOUT_S = 120.0
RESET_TIMEOUT_S = LOAD_TIMEOUT_S  # a server that was started anew compiles
_END_TIMEOUT_S = 1.0
_KEEPER = str(Path(__file__).with_name("policy_keeper.py"))


class PolicyWorker:
    """One policy in one process, asked from one event loop; calls take turns.

    ``added_latency_s``: by how much each answer of `infer` is late on purpose.

    After a call that raised, or was cancelled, the process is gone, so a late answer cannot be
    taken for the answer to a later question; `load` starts a new one.

    A keeper holds the process: with it ends whatever the policy started, also in a session of its
    own. So it does when the runner is gone, however that ended.
    """

    def __init__(
        self,
        policy: Plugin,
        skill: SkillManifest,
        options: Mapping[str, JsonValue],
        robot: str = "",
        profile: str = "",
        added_latency_s: float = 0.0,
    ) -> None:
        self._added_latency_s = added_latency_s
        self._request = Load(
            policy, skill.model_dump_json(), json.dumps(dict(options)), robot, profile
        )
        self._skill = skill
        self._reply_max = reply_max_bytes(skill.action_contract.dim, skill.horizon)
        self._process: asyncio.subprocess.Process | None = None
        self._pipe: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None
        self._held: int | None = None
        self._turn = asyncio.Lock()
        self._loading: asyncio.Task[None] | None = None

    @property
    def pid(self) -> int | None:
        """Process id of the policy's keeper while it runs."""
        return self._process.pid if self._process else None

    async def load(self, timeout_s: float = LOAD_TIMEOUT_S) -> None:
        """Start the process and load the policy, unless that has been done.

        Who asks while it loads waits for the same; who gives up ends it for all of them.

        Raises:
            PolicyError: if it cannot be loaded in time.
        """
        if self._loading is None or self._loading.done():
            self._loading = asyncio.create_task(self._load_anew(timeout_s), name="load")
        try:
            await self._loading
        except asyncio.CancelledError:
            task = asyncio.current_task()
            if task is not None and task.cancelling():
                raise
            raise PolicyError("policy worker: loading was ended") from None

    async def _load_anew(self, timeout_s: float) -> None:
        async with self._turn:
            if self._process is None or self._process.returncode is not None:
                await self._end()
                try:
                    await self._start()
                except BaseException:
                    await self._end(at_once=True)
                    raise
                await self._ask(self._request, "loading", timeout_s)

    async def _start(self) -> None:
        ours, theirs = socket.socketpair()
        read_end, self._held = os.pipe()
        policy = [sys.executable, "-m", "fairlead_skill_runner.policy_process"]
        try:
            self._process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-I", "-S", _KEEPER, str(theirs.fileno()), *policy),
                pass_fds=[theirs.fileno()],
                stdin=read_end,
                process_group=0,
            )
        except BaseException:
            ours.close()
            self._kill()
            raise
        finally:
            theirs.close()
            os.close(read_end)
        self._pipe = await asyncio.open_unix_connection(sock=ours)

    async def reset(self) -> None:
        """Tell the policy that a new goal begins.

        Raises:
            PolicyError: if it fails or takes too long.
        """
        async with self._turn:
            await self._ask(Reset(), "reset", RESET_TIMEOUT_S)

    async def infer(self, observation: Observation) -> Actions | Done | Failed:
        """Ask for rows, float32 ``[H, dim]``, finite, H at most the skill's horizon, or an end.

        Raises:
            PolicyError: if the policy fails, takes longer than the skill's
                ``inference_timeout_s``, or returns anything else.
        """
        skill = self._skill
        async with self._turn:
            answer = await self._ask(Infer.of(observation), "inference", skill.inference_timeout_s)
            if self._added_latency_s:
                await asyncio.sleep(self._added_latency_s)
            try:
                if isinstance(answer, Ended):
                    return answer.end()
                return check_actions(answer, skill.action_contract.dim, skill.horizon)
            except PolicyError:
                await self._end(at_once=True)
                raise

    async def answer(self, observation: Observation) -> Actions | Done | Failed | PolicyError:
        """As `infer`; what it raises is an answer too, and is logged."""
        try:
            return await self.infer(observation)
        except PolicyError as error:
            logging.getLogger("policy").error("%s", error)
            return error

    async def close(self) -> None:
        """End the process; a call that is still running fails, a load is cancelled."""
        if self._loading is not None:
            self._loading.cancel()
        if self._turn.locked() and self._process is not None:
            self._kill()
        async with self._turn:
            await self._end()

    async def _ask(self, request: Request, what: str, timeout_s: float) -> Answer | Ended:
        if self._pipe is None:
            raise PolicyError(f"policy worker: {what} asked, but no policy is loaded")
        reader, writer = self._pipe
        try:
            async with asyncio.timeout(timeout_s):
                message = encode(request)
                writer.write(HEADER.pack(len(message)))
                writer.write(message)
                await writer.drain()
                (size,) = HEADER.unpack(await reader.readexactly(HEADER.size))
                if size > self._reply_max:
                    what_came = f"a reply of at most {self._reply_max} bytes, got {size}"
                    raise PolicyError(f"policy worker: {what}: expected {what_came}")
                reply = decode_reply(await reader.readexactly(size))
            if isinstance(reply, Raised):
                raise PolicyError(f"policy worker: {what} failed: {reply.text}")
            return reply
        except TimeoutError:
            await self._end(at_once=True)
            raise PolicyError(f"policy worker: {what} took longer than {timeout_s:g} s") from None
        except (OSError, EOFError):
            status = await self._end()
            ended = f"the process ended with status {status}"
            raise PolicyError(f"policy worker: {what}: {ended}") from None
        except BaseException:
            await self._end(at_once=True)
            raise

    async def _end(self, at_once: bool = False) -> int | None:
        """By force if it does not listen, or ``at_once``; its exit status, if there was one."""
        process, pipe = self._process, self._pipe
        self._pipe = None
        if pipe is not None:
            pipe[1].close()
        if process is None:
            return None
        if at_once:
            self._kill()
        ending = asyncio.ensure_future(process.wait())
        try:
            await asyncio.wait({ending}, timeout=_END_TIMEOUT_S)  # as in `Changes`
        finally:
            self._kill()
            self._process = None
        return await ending

    def _kill(self) -> None:
        """The keeper ends all when nobody holds its standard input any more; paused it is woken."""
        if self._held is not None:
            os.close(self._held)
            self._held = None
            if self._process is not None:
                with suppress(ProcessLookupError):
                    self._process.send_signal(signal.SIGCONT)
