"""One supervisor over shell scripts that stand in for the services."""

from __future__ import annotations

import os
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


def wait_until(condition: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + WAIT_S
    while not condition():
        assert time.monotonic() < deadline, f"not within {WAIT_S:g} s: {what}"
        os.sched_yield()


class Bench:
    """One supervisor over shell scripts, and what its services printed.

    problem: raised instead of building a command. argument: a file that the commands name.
    """

    def __init__(self, file: Path, folder: Path) -> None:
        self.scripts = {"hal": OBEDIENT, "runner": OBEDIENT}
        self.lines: list[tuple[str, str]] = []
        self.problem: Exception | None = None
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
            on_line=lambda service, line: self.lines.append((service, line)),
            registry=self.registry,
            command=self._command,
        )

    def _command(self, file: Path, deployment: Deployment, name: str, state: Path) -> list[str]:
        if self.problem is not None:
            raise self.problem
        return ["sh", "-c", self.scripts[name].replace("{name}", name), "sh", str(self.argument)]

    def poll_until(self, kind: str) -> ServiceEvent:
        found: list[ServiceEvent] = []

        def happened() -> bool:
            found.extend(event for event in self.supervisor.poll() if event.kind == kind)
            return bool(found)

        wait_until(happened, f"an event {kind}")
        return found[0]
