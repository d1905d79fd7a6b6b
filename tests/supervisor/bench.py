"""One supervisor over shell scripts that stand in for the services."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable
from pathlib import Path

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.registry import Registry
from fairlead_tools.supervisor import ServiceEvent, Supervisor

WAIT_S = 20.0
OBEDIENT = "echo '{name}: ready'; exec sleep 1000"
STUBBORN = "trap '' TERM; echo '{name}: ready'; while true; do sleep 0.1; done"
WITH_A_CHILD = "sleep 1000 & echo \"child $!\"; echo '{name}: ready'; wait"


async def wait_until(condition: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + WAIT_S
    while not condition():
        assert time.monotonic() < deadline, f"not within {WAIT_S:g} s: {what}"
        await asyncio.sleep(0)


class Bench:
    """One supervisor over shell scripts, and what its services printed.

    problem: raised instead of building a command. argument: a file that the commands name.
    takes_lines: cleared, whoever prints the lines is stuck.
    """

    def __init__(self, file: Path, folder: Path) -> None:
        self.scripts = {"hal": OBEDIENT, "runner": OBEDIENT}
        self.lines: list[tuple[str, str]] = []
        self.events: asyncio.Queue[ServiceEvent] = asyncio.Queue()
        self.takes_lines = threading.Event()
        self.takes_lines.set()
        self._keeping: asyncio.Task[None] | None = None
        self.problem: Exception | None = None
        self.program = "sh"
        self.argument = folder
        self.registry = Registry(folder / "registry")
        self.state_dir = folder / "state"
        self._file = file
        self.supervisor = self.another()

    def another(self) -> Supervisor:
        return Supervisor(
            self._file,
            load_deployment(self._file),
            self.state_dir,
            on_line=self._on_line,
            registry=self.registry,
            command=self._command,
        )

    def _on_line(self, service: str, line: str) -> None:
        self.lines.append((service, line))
        self.takes_lines.wait(WAIT_S)

    def _command(self, file: Path, deployment: Deployment, name: str, state: Path) -> list[str]:
        if self.problem is not None:
            raise self.problem
        return [
            self.program,
            "-c",
            self.scripts[name].replace("{name}", name),
            "sh",
            str(self.argument),
        ]

    async def start(self) -> None:
        """Until all are ready."""
        await self.supervisor.start()
        await self.supervisor.wait_ready(WAIT_S)

    def keep(self) -> None:
        """Have what dies started again, until the test ends."""
        keeping = self.supervisor.keep(self.events.put_nowait)
        self._keeping = asyncio.create_task(keeping)

    async def event(self, kind: str) -> str:
        """What the next event of a kind says."""
        async with asyncio.timeout(WAIT_S):
            while (event := await self.events.get()).kind != kind:
                continue
        return event.text

    async def end(self) -> None:
        self.takes_lines.set()
        if self._keeping is not None:
            self._keeping.cancel()
            await asyncio.wait({self._keeping})
        await self.supervisor.stop(grace_s=0.0)
