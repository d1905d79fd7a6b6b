"""Limits that are changed while the robot is up: what the gate says, and that its advice works."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.system.person import ROOT, Person, person_at

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]

COMPOSE = "compose/panda_mujoco.yaml"
STEP = "      stop_window_s: 60\n"


@pytest.fixture
def person(tmp_path: Path) -> Iterator[Person]:
    """With a checkout of robots of their own, and a deployment that is up."""
    with person_at(tmp_path, COMPOSE, "edit") as person:
        person.root = tmp_path / "tree"
        shutil.copytree(ROOT / "robots", person.root / "robots")
        for folder in ("rskills", "build"):
            (person.root / folder).symlink_to(ROOT / folder)
        up = person.start(f".venv/bin/fairlead up {COMPOSE}", "up")
        up.wait_for(lambda line: " is up;" in line, "the robot is up")
        yield person
        assert person.fairlead("down").returncode == 0


def test_a_gate_whose_file_has_changed_is_armed_after_what_its_refusal_advises(
    person: Person,
) -> None:
    manifest = person.root / "robots/panda/robot.yaml"
    text = manifest.read_text(encoding="utf-8")
    assert text.count(STEP) == 1
    manifest.write_text(text.replace(STEP, STEP.replace("60", "61")), encoding="utf-8")
    compiled = person.fairlead("robot", "compile", "panda")
    assert compiled.returncode == 0, compiled.stderr

    refused = person.fairlead("arm")
    assert refused.returncode == 1
    reason, advice = refused.stderr.splitlines()
    assert "the configuration file has changed since the gate read it" in reason
    advised = advice.removeprefix("  try: fairlead ")
    assert advised == "restart safety; fairlead restart hal"
    for words in advised.split("; fairlead "):
        done = person.fairlead(*words.split())
        assert done.returncode == 0, done.stderr
    armed = person.fairlead("arm")
    assert armed.returncode == 0, armed.stderr
