"""Somebody who gives a document's commands in terminals, in a folder that looks like a checkout."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.equipment.live_robot import wait_for
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch

ROOT = repo_root()


@dataclass
class Terminal:
    """One command in the foreground, as a person started it."""

    process: subprocess.Popen[str]
    lines: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as stream:
            self.lines.extend(line.rstrip() for line in stream)

    def wait_for(self, is_it: Callable[[str], bool], what: str) -> None:
        """Until a line is printed for which ``is_it`` holds."""
        wait_for(lambda: any(is_it(line) for line in self.lines), what, 120.0)

    def wait_ready(self) -> None:
        self.wait_for(lambda line: line == "ready" or line.endswith(": ready"), "it is ready")

    def ctrl_c(self) -> int:
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(timeout=30.0)


@dataclass
class Person:
    """Gives commands in ``folder``; ``root`` is where robots and skills are found."""

    folder: Path
    root: Path = ROOT
    more_environment: Mapping[str, str] = field(default_factory=dict)
    terminals: dict[str, Terminal] = field(default_factory=dict)

    @property
    def environment(self) -> dict[str, str]:
        return {
            **os.environ,
            "FAIRLEAD_ROOT": str(self.root),
            "FAIRLEAD_STATE": str(self.folder / "state"),
            "COLUMNS": "200",
            "NO_COLOR": "1",
            **self.more_environment,
        }

    def start(self, line: str, name: str = "") -> Terminal:
        """In a terminal of its own, named after the command's last word."""
        process = subprocess.Popen(
            ["bash", "-c", f"exec {line}"],
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        terminal = self.terminals[name or line.split()[-1]] = Terminal(process)
        return terminal

    def shell(self, line: str) -> subprocess.CompletedProcess[str]:
        """Until the command ends."""
        return subprocess.run(
            ["bash", "-c", line],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    def fairlead(self, *words: str) -> subprocess.CompletedProcess[str]:
        return self.shell(" ".join((".venv/bin/fairlead", *words)))

    def states(self) -> dict[str, str]:
        """By service, what `ps` says of it."""
        (entry,) = json.loads(self.fairlead("ps", "--json").stdout)
        return {name: one["state"] for name, one in entry["services"].items()}


@contextmanager
def person_at(
    tmp_path: Path, compose: str, name: str, hal: dict[str, Any] | None = None
) -> Iterator[Person]:
    """A deployment file with its own ports and name; what still runs at the end is killed."""
    scratch = make_scratch(
        ROOT / compose,
        tmp_path / "scratch",
        ScratchOptions(f"{name}{os.getpid()}", hal=hal),
    )
    folder = tmp_path / "checkout"
    (folder / "compose").mkdir(parents=True)
    (folder / compose).write_bytes(scratch.file.read_bytes())
    (folder / ".venv").symlink_to(sys.prefix)
    person = Person(folder)
    yield person
    for terminal in person.terminals.values():
        terminal.process.terminate()
    for terminal in person.terminals.values():
        terminal.process.wait(timeout=30.0)
