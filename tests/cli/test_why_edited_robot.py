"""``fairlead why`` while robot.yaml is edited: the key is looked up in the file as it is now."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.gate_scene import Scene
from bench.equipment.running_gate import ROBOT
from fairlead.messages import Outcome, pack_floats
from fairlead.paths import gate_config
from tests.cli.command import fairlead_here as fairlead

pytestmark = pytest.mark.processes

LIMIT = "          linear_limit_m: 0.0867\n"


@pytest.fixture
def edited(tmp_path: Path) -> Iterator[Path]:
    """A robot.yaml beside the gate file of a gate that refused 0.09 m, limit 0.0867 m."""
    source = gate_config(ROBOT, "sim")
    shutil.copytree(source.parent, tmp_path, dirs_exist_ok=True)
    config, manifest = tmp_path / source.name, tmp_path / "robot.yaml"
    scene = Scene(config, tmp_path / "run" / "safety")
    try:
        scene.ready_to_move()
        values = np.zeros((1, 6))
        values[0, 0] = 0.09
        part = scene.arm_part(1, values=pack_floats(values))
        assert scene.send(scene.chunk(1, parts=(part,))).outcome == Outcome.REFUSED
        scene.silence()
        assert scene.gate.stop() == 0
    finally:
        scene.close()
    yield manifest


def why(manifest: Path) -> str:
    folder = manifest.parent
    done = fairlead("why", "--state-dir", str(folder / "run"), state=folder / "registry")
    assert (done.returncode, done.stderr) == (0, "")
    assert "why     G020 limit: row 0, arm linear is 0.09 m, limit 0.0867 m" in done.stdout
    return str(done.stdout)


def test_a_limit_that_was_loosened_since_is_not_blamed_on_the_claim(edited: Path) -> None:
    key = "safety.sim.parts.arm.cartesian_delta.linear_limit_m"
    assert f"{key}\n" in why(edited)
    text = edited.read_text(encoding="utf-8")
    assert LIMIT in text
    edited.write_text(text.replace(LIMIT, LIMIT.replace("0.0867", "0.2"), 1), encoding="utf-8")
    assert f"{key} is 0.2, made tighter by the claim, or changed since\n" in why(edited)


@pytest.mark.parametrize("broken", [b"joints: [", b"\xff\xfe", b"- a\n", b"joints: [3, null]\n"])
def test_a_file_that_is_no_robot_at_the_moment_names_no_key(edited: Path, broken: bytes) -> None:
    edited.write_bytes(broken)
    assert "robot.yaml: " not in why(edited)
