"""The commands of my-first-robot.md and hal.md, run as they stand there in a clean folder."""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from fairlead.robot.manifest import load_robot
from fairlead_tools.shape.recorded_positions import recorded_positions
from tests.system.person import ROOT, Person

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

WAVED_RAD = 0.15
"""The skeleton waves 0.2 rad to each side; a busy machine may have time for one of them."""
DOCS, EXAMPLES = ROOT / "docs", ROOT / "docs" / "examples"


@pytest.fixture
def newcomer(tmp_path: Path) -> Iterator[Person]:
    folder = tmp_path / "clean"
    folder.mkdir()
    (folder / ".venv").symlink_to(sys.prefix)
    for example in ("my_arm.xml", "minimal_hal.py"):
        shutil.copy(EXAMPLES / example, folder)
    own = {f"FAIRLEAD_{one}": str(tmp_path / one.lower()) for one in ("ROBOTS", "SKILLS")}
    person = Person(folder, more_environment=own)
    yield person
    for terminal in person.terminals.values():
        terminal.process.terminate()
        terminal.process.wait(timeout=30.0)


def commands(document: str) -> list[str]:
    text = (DOCS / document).read_text(encoding="utf-8")
    blocks = re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S)
    return [line for block in blocks for line in block.splitlines()]


def walked(newcomer: Person, lines: list[str]) -> list[str]:
    """What each command printed, but for the robot that is up in its terminal."""
    said: list[str] = []
    for line in lines:
        if " up " in line:
            up = newcomer.start(line, "up")
            up.wait_for(lambda line: " is up" in line, "the robot is up")
            continue
        done = newcomer.shell(line)
        wanted = 1 if " run " in line else 0
        assert done.returncode == wanted, f"{line}\n{done.stdout}{done.stderr}"
        said.append(done.stdout)
    assert "refused" not in "".join(newcomer.terminals["up"].lines)
    assert newcomer.terminals["up"].process.wait(timeout=30.0) == 0
    return said


def farthest(newcomer: Person, monkeypatch: pytest.MonkeyPatch) -> float:
    """How far the joint that moved most was moved [rad]."""
    monkeypatch.setenv("FAIRLEAD_ROBOTS", newcomer.more_environment["FAIRLEAD_ROBOTS"])
    log = next((newcomer.folder / "state").rglob("*.decisions"))
    return float(np.ptp(recorded_positions(load_robot("my_arm"), log), axis=0).max())


def test_my_first_robot_brings_a_robot_that_moves(
    newcomer: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    new, unasked, _, run, asked, _ = walked(newcomer, commands("my-first-robot.md"))
    assert "hal_mujoco cannot move it" not in new
    assert re.search(r"^HAL +open +none runs on this machine", unasked, re.M)
    assert "my-arm-wave deadline after 6" in run
    assert re.search(r"^HAL +ok +joints, parts, modes and period as in robot.yaml", asked, re.M)
    assert farthest(newcomer, monkeypatch) > WAVED_RAD


@pytest.mark.thorough
def test_my_hal_brings_a_hal_of_ones_own_that_moves_the_robot(
    newcomer: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    *_, run, asked, _ = walked(newcomer, [commands("my-first-robot.md")[0], *commands("hal.md")])
    assert "command: [python, ./minimal_hal.py]" in (newcomer.folder / "my_arm.yaml").read_text()
    assert any("minimal" in line for line in newcomer.terminals["up"].lines if "[hal]" in line)
    assert "my-joint-wave deadline after 6" in run
    assert re.search(r"^HAL +ok +joints, parts, modes and period as in robot.yaml", asked, re.M)
    assert farthest(newcomer, monkeypatch) > WAVED_RAD
