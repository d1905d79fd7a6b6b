"""docs/my-first-robot.md works: its commands are run as they stand there, in a clean folder."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from fairlead.robot.manifest import load_robot
from fairlead_tools.shape.recorded_positions import recorded_positions
from tests.system.person import ROOT, Person

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

DOCUMENT = (ROOT / "docs" / "my-first-robot.md").read_text(encoding="utf-8")


@pytest.fixture
def newcomer(tmp_path: Path) -> Iterator[Person]:
    folder = tmp_path / "clean"
    folder.mkdir()
    (folder / ".venv").symlink_to(sys.prefix)
    shutil.copy(ROOT / "docs" / "examples" / "my_arm.xml", folder)
    own = {f"FAIRLEAD_{one}": str(tmp_path / one.lower()) for one in ("ROBOTS", "SKILLS")}
    person = Person(folder, more_environment=own)
    yield person
    for terminal in person.terminals.values():
        terminal.process.terminate()
        terminal.process.wait(timeout=30.0)


def test_the_commands_of_the_document_bring_a_robot_that_moves(
    newcomer: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[subprocess.CompletedProcess[str]] = []
    for block in re.findall(r"^```sh\n(.*?)^```", DOCUMENT, re.M | re.S):
        for line in block.splitlines():
            if " up " in line:
                up = newcomer.start(line, "up")
                up.wait_for(lambda line: " is up" in line, "the robot is up")
                continue
            done.append(newcomer.shell(line))
            wanted = 1 if " run " in line else 0
            assert done[-1].returncode == wanted, f"{line}\n{done[-1].stdout}{done[-1].stderr}"
    new, unasked, _, run, asked, _ = (one.stdout for one in done)
    assert "hal_mujoco cannot move it" not in new
    assert re.search(r"^HAL +open +none runs on this machine", unasked, re.M)
    assert "my-wave deadline after 6" in run
    assert re.search(r"^HAL +ok +joints, parts, modes and period as in robot.yaml", asked, re.M)
    assert "refused" not in "".join(newcomer.terminals["up"].lines)
    monkeypatch.setenv("FAIRLEAD_ROBOTS", newcomer.more_environment["FAIRLEAD_ROBOTS"])
    log = next((newcomer.folder / "state").rglob("*.decisions"))
    measured = recorded_positions(load_robot("my_arm"), log)
    assert np.ptp(measured, axis=0).max() > 0.2  # rad: one joint waved
    assert newcomer.terminals["up"].process.wait(timeout=30.0) == 0
