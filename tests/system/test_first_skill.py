"""docs/my-first-skill.md works: its commands are run as they stand there."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from fairlead.paths import repo_root
from fairlead.supervisor.scratch import ScratchOptions, make_scratch
from tests.system.light_hal import LIGHT_HAL
from tests.system.live_robot import wait_for

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

ROOT = repo_root()
DOCUMENT = (ROOT / "docs" / "my-first-skill.md").read_text(encoding="utf-8")
COMPOSE = "compose/panda_mobile_sim.yaml"


def commands() -> list[str]:
    blocks = re.findall(r"^```sh\n(.*?)^```", DOCUMENT, re.M | re.S)
    return [line for block in blocks for line in block.splitlines()]


@dataclass
class Newcomer:
    """A shell in a folder that looks like the checkout; the deployment has its own ports."""

    folder: Path
    up: subprocess.Popen[str] | None = None
    lines: list[str] = field(default_factory=list)

    @property
    def environment(self) -> dict[str, str]:
        return os.environ | {
            "FAIRLEAD_ROOT": str(ROOT),
            "FAIRLEAD_SKILLS": str(self.folder / "data" / "rskills"),
            "FAIRLEAD_STATE": str(self.folder / "state"),
        }

    def shell(self, line: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            ["bash", "-c", line],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    def start(self, line: str) -> None:
        self.up = subprocess.Popen(
            ["bash", "-c", f"exec {line}"],
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        threading.Thread(target=self._read, args=(self.up,), daemon=True).start()
        wait_for(lambda: any(" is up" in text for text in self.lines), "the robot is up", 120.0)

    def _read(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        with process.stdout as stream:
            self.lines.extend(stream)


@pytest.fixture
def newcomer(tmp_path: Path) -> Iterator[Newcomer]:
    options = ScratchOptions(f"wave{os.getpid()}", options={"hal": LIGHT_HAL})
    scratch = make_scratch(ROOT / COMPOSE, tmp_path / "scratch", options)
    folder = tmp_path / "checkout"
    (folder / "compose").mkdir(parents=True)
    (folder / COMPOSE).write_bytes(scratch.file.read_bytes())
    (folder / ".venv").symlink_to(sys.prefix)
    person = Newcomer(folder)
    yield person
    if person.up is not None and person.up.poll() is None:
        person.up.terminate()
        person.up.wait(timeout=30.0)


def test_the_commands_of_the_document_do_what_it_says(newcomer: Newcomer) -> None:
    done: dict[str, subprocess.CompletedProcess[str]] = {}
    for line in commands():
        if " up " in line:
            newcomer.start(line)
            continue
        result = done[line.removeprefix(".venv/bin/fairlead ")] = newcomer.shell(line)
        wanted = 1 if " run " in line else 0
        assert result.returncode == wanted, f"{line}\n{result.stdout}{result.stderr}"
    assert re.search(r"^my-wave +admitted$", done["skill ls --robot panda_mobile"].stdout, re.M)
    printed = re.search(r"^```text\n(.*)\n```", DOCUMENT, re.M)
    assert printed
    shape = re.escape(printed.group(1)).replace("65", r"6\d")  # it ends with a policy call
    said = done["run my-wave --deadline-ticks 60"].stdout.rstrip("\n")
    assert re.fullmatch(shape, said), said
    assert "deadline" in done["topic echo skill/runner/feedback --count 1"].stdout
    assert newcomer.up is not None and newcomer.up.wait(timeout=30.0) == 0
