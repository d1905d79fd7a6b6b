"""docs/my-first-skill.md works: its commands are run as they stand there."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.light_hal import LIGHT_HAL
from tests.system.person import ROOT, Person, person_at

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

DOCUMENT = (ROOT / "docs" / "my-first-skill.md").read_text(encoding="utf-8")
COMPOSE = "compose/panda_mobile_sim.yaml"


def commands() -> list[str]:
    blocks = re.findall(r"^```sh\n(.*?)^```", DOCUMENT, re.M | re.S)
    return [line for block in blocks for line in block.splitlines()]


@pytest.fixture
def newcomer(tmp_path: Path) -> Iterator[Person]:
    with person_at(tmp_path, COMPOSE, "wave", LIGHT_HAL) as person:
        person.more_environment = {"FAIRLEAD_SKILLS": str(person.folder / "data" / "rskills")}
        yield person


@pytest.mark.thorough
def test_the_commands_of_the_document_do_what_it_says(newcomer: Person) -> None:
    done: dict[str, subprocess.CompletedProcess[str]] = {}
    for line in commands():
        if " up " in line:
            newcomer.start(line, "up").wait_for(lambda line: " is up" in line, "the robot is up")
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
    assert newcomer.terminals["up"].process.wait(timeout=30.0) == 0
