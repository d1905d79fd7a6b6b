"""One process of a deployment: start it, read what it prints, end it with its children."""

from __future__ import annotations

import asyncio
import os
import shutil
import signal
import subprocess
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

from fairlead.deploy.process_table import ProcessId, group_members, process_id
from fairlead.errors import ServiceError
from fairlead.log_stamp import stamped
from fairlead_tools.supervisor.lines import Lines
from fairlead_tools.supervisor.service_log import ServiceLog

LineHandler = Callable[[str, str], None]
"""Gets the service's name and one line it printed."""

LAST_LINES = 15  # enough for a Python error's last frames
READ_BYTES = 1 << 16
LAST_WORDS_S = 0.2  # for its last lines to be read, where something it started still lives
KILLED_S = 2.0
LOOK_AGAIN_S = 0.02


class Child:
    """A running process in a process group of its own (so Ctrl-C reaches us first).

    In the supervisor's session: the kernel gives sessions processor time as groups, so that in ones
    of their own a HAL that has just computed would wait for every other service.

    To be made on the event loop that watches it and reads its output.

    Args:
        name: the service's name.
        command: what to execute.
        environment: its whole environment.
        log: the file its lines are appended to.
        on_line: called for every line, from the thread that writes the file.
        on_change: called on the loop when it is ready, and when it has ended.

    Attributes:
        ready: whether it has said so.
        ended: whether it has ended, and what it printed before is known.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        environment: dict[str, str],
        log: Path,
        on_line: LineHandler,
        on_change: Callable[[], None],
    ) -> None:
        self.name = name
        self.ready = self.ended = self._group_is_gone = False
        self.last_lines: deque[str] = deque(maxlen=LAST_LINES)
        self._log, self._on_line, self._on_change = ServiceLog(log), on_line, on_change
        self._writer = ThreadPoolExecutor(1, thread_name_prefix=f"{name}-log")
        self._process = subprocess.Popen(
            die_with_parent(command),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=environment,
            process_group=0,
        )
        try:
            handle = os.pidfd_open(self.pid)
            self._writer.submit(int)  # now there is a thread
        except (OSError, RuntimeError):  # nobody would see it end, or read what it prints
            self._process.kill()
            self._process.wait()
            raise
        self.process_id = process_id(self.pid) or ProcessId(self.pid, 0)
        self._reading = asyncio.create_task(self._read(), name=f"{name} output")
        self._watching = asyncio.create_task(self._watch(handle), name=f"{name} end")

    @property
    def pid(self) -> int:
        """Process id, also after the process has ended."""
        return self._process.pid

    @property
    def exit_status(self) -> int | None:
        """None while it runs; negative: the signal that ended it."""
        return self._process.poll()

    def ask_to_stop(self) -> None:
        """SIGTERM to the process; it ends its own children. A stopped one is woken first."""
        if self.exit_status is None:
            self._process.terminate()
            self._process.send_signal(signal.SIGCONT)

    async def kill_group(self) -> list[int]:
        """SIGKILL to the process and what it started that is still there, in its group.

        Returns:
            Process ids of what lives on after 2 s: stuck in the kernel, or another user's.

        Raises:
            OSError: the kernel does not say what is there.
        """
        if self._group_is_gone:  # another group may have its number by now
            return []
        end_s = time.monotonic() + KILLED_S
        if group_members(self.pid):
            with suppress(ProcessLookupError, PermissionError):  # just ended; another user's
                os.killpg(self.pid, signal.SIGKILL)
        await asyncio.wait({self._watching, self._reading}, timeout=KILLED_S)
        self._reading.cancel()
        while (left := group_members(self.pid)) and time.monotonic() < end_s:  # noqa: ASYNC110 - no event tells
            await asyncio.sleep(LOOK_AGAIN_S)
        self._group_is_gone = self.ended and not left
        return left

    async def _watch(self, handle: int) -> None:
        gone, loop = asyncio.Event(), asyncio.get_running_loop()
        loop.add_reader(handle, gone.set)
        try:
            await gone.wait()
        finally:
            loop.remove_reader(handle)
            os.close(handle)
        self._process.wait()
        await asyncio.wait({self._reading}, timeout=LAST_WORDS_S)
        self.ended = True
        self._on_change()

    async def _read(self) -> None:
        stream, loop = asyncio.StreamReader(), asyncio.get_running_loop()
        pipe, _ = await loop.connect_read_pipe(
            lambda: asyncio.StreamReaderProtocol(stream), self._process.stdout
        )
        lines = Lines()
        try:
            while data := await stream.read(READ_BYTES):
                await self._take(lines.take(data))
            await self._take(lines.end())
        finally:
            pipe.close()
            self._writer.submit(self._log.close)
            self._writer.shutdown(wait=False)

    async def _take(self, lines: list[str]) -> None:
        self.last_lines.extend(lines)
        if not self.ready and any(is_ready_line(line) for line in lines):
            self.ready = True
            self._on_change()
        await asyncio.get_running_loop().run_in_executor(self._writer, self._write, lines)

    def _write(self, lines: list[str]) -> None:
        for line in lines:
            trouble = self._log.append(stamped(line, self.name))
            self._on_line(self.name, line)
            if trouble:
                self._on_line(self.name, trouble)


def is_ready_line(line: str) -> bool:
    """Whether a service says that it is up: ``ready`` (gate), ``INFO hal: ready`` (Python)."""
    return line == "ready" or line.endswith(": ready")


_IF_PARENT_LIVES = '[ "$PPID" = "$0" ] && exec "$@"'


def die_with_parent(command: Sequence[str]) -> list[str]:
    """The command, started so that the kernel ends it with the *thread* that forked it.

    So children must be started from a thread that lives as long as the supervisor. Python's
    ``preexec_fn`` would do the same, but hangs now and then in a process with threads of Zenoh's:
    one of them may hold a lock of the interpreter at the moment of the fork.

    Raises:
        ServiceError: ``setpriv`` (of util-linux) is not there.
    """
    setpriv = shutil.which("setpriv")
    if setpriv is None:
        raise ServiceError("setpriv, which starts services, is not found; apt install util-linux")
    # The shell looks whether the parent died before the kernel knew.
    check = ["/bin/sh", "-c", _IF_PARENT_LIVES, str(os.getpid())]
    return [setpriv, "--pdeathsig", "KILL", "--", *check, *command]
