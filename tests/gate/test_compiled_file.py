"""A gate starts on what was compiled from the robot beside it, and on nothing else."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from bench.equipment.running_gate import RunningGate
from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError
from fairlead.paths import deployment_path, gate_binary, robot_dir
from fairlead.robot.gate_file import sealed
from fairlead_tools.supervisor.child import is_ready_line
from fairlead_tools.supervisor.command_line import check_gate_file
from tests.cli.command import fairlead_here as fairlead

pytestmark = pytest.mark.processes

ROBOT = "edited"
FIX = f"; make it anew with: fairlead robot compile {ROBOT}"
EDITED = "content_sha256: expected the file as it was compiled, got one that was edited afterwards"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A robot of one's own, compiled."""
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(tmp_path / "robots"))
    found = tmp_path / "robots" / ROBOT
    shutil.copytree(robot_dir("panda"), found)
    (found / "panda.xml").rename(found / f"{ROBOT}.xml")
    manifest = found / "robot.yaml"
    manifest.write_text(manifest.read_text().replace("id: panda\n", f"id: {ROBOT}\n", 1))
    assert fairlead("robot", "compile", ROBOT, state=tmp_path).returncode == 0
    return found


def start(config: Path, state: Path) -> tuple[int, str]:
    """Status and last line of a gate that refuses to start, or that is ended once it is ready."""
    gate = RunningGate(config, state, robot=ROBOT)
    try:
        while True:
            line = gate.wait_line("")
            if is_ready_line(line):
                return gate.stop(), "ready"
            if line.startswith("ERROR"):
                return gate.wait_exit(), line
    finally:
        gate.close()


def checked(config: Path) -> tuple[int, str]:
    """What the checks before a start say of a file."""
    words = [str(gate_binary()), "check", str(config)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout.strip()


def test_a_limit_written_into_the_gate_file_by_hand_is_refused_at_start_and_by_up(
    folder: Path, tmp_path: Path
) -> None:
    config = folder / "gate.sim.json"
    text = config.read_text()
    config.write_text(text.replace('"velocity_limit": 2.175', '"velocity_limit": 21.75'))
    status, line = start(config, tmp_path / "gate")
    assert status == 2
    assert line.startswith(f"ERROR fairlead-safety: configuration {config}: {EDITED}")
    assert line.endswith(FIX)
    deployment = tmp_path / "one.yaml"
    services = {kind: {"run": kind} for kind in ("hal_mujoco", "safety", "skill_runner")}
    deployment.write_text(
        yaml.safe_dump({"robot": ROBOT, "id": ROBOT, "pacing": "lockstep", "services": services})
    )
    up = fairlead("up", str(deployment), "--state-dir", str(tmp_path / "up"), state=tmp_path)
    assert up.returncode == 1
    assert f"ERROR configuration {config}: {EDITED}" in up.stderr and FIX in up.stderr
    assert not (tmp_path / "up").exists(), "nothing was started"


def test_what_it_was_compiled_from_is_compared_file_by_file(folder: Path, tmp_path: Path) -> None:
    config, manifest, urdf = (
        folder / name for name in ("gate.sim.json", "robot.yaml", "panda.urdf")
    )
    assert checked(config) == (0, f"{config}: as it was compiled from the robot.yaml beside it")
    text = manifest.read_text()
    manifest.write_text(text.replace("velocity_rad_s: 2.61", "velocity_rad_s: 1.0", 1))
    status, line = start(config, tmp_path / "gate")
    assert status == 2
    assert (
        "compiled_from: expected the files beside it as they were, got others: robot.yaml" in line
    )
    assert line.endswith(FIX)
    urdf.write_text(urdf.read_text() + "\n")
    assert "got others: panda.urdf, robot.yaml;" in checked(config)[1]
    (folder / "capsules.yaml").unlink()
    assert "got others: capsules.yaml, panda.urdf, robot.yaml;" in checked(config)[1]


def test_a_file_deployed_alone_starts_if_nobody_has_changed_it(
    folder: Path, tmp_path: Path
) -> None:
    alone = tmp_path / "gate.sim.json"
    shutil.copy(folder / "gate.sim.json", alone)
    assert start(alone, tmp_path / "gate") == (0, "ready")
    assert checked(alone)[1].endswith("as it was compiled; no robot.yaml beside it to compare with")
    text = alone.read_text()
    alone.write_text(text.replace('"horizon_max": 64', '"horizon_max": 63'))
    status, line = checked(alone)
    assert status == 2 and EDITED in line


@pytest.mark.parametrize(
    ("spoil", "wanted"),
    [
        (lambda text: re.sub(r',\s*"content_sha256": "\w*"', "", text), "got none"),
        (lambda text: re.sub(r'"compiled_from": \{[^}]*\},', "", text), "got none"),
        (lambda text: sealed(text.replace('"robot.yaml": "', '"robot.yml": "')), "got none"),
        (lambda text: text.replace('"content_sha256": "', '"content_sha256": "0'), EDITED),
        (lambda text: text + " x", "expected JSON"),
        (lambda text: re.sub(r'("content_sha256": "\w*)"', r'\1", "lockstep_allowed": true', text),
         "duplicate key"),
    ],
)  # fmt: skip
def test_a_file_that_cannot_prove_what_it_is_is_refused(
    folder: Path, spoil: object, wanted: str
) -> None:
    assert callable(spoil)
    config = folder / "gate.sim.json"
    config.write_text(spoil(config.read_text()))
    status, line = checked(config)
    assert status == 2
    assert wanted in line


def test_a_deployment_is_told_in_the_gates_own_words() -> None:
    deployment = load_deployment(deployment_path("panda_mujoco"))
    check_gate_file(deployment)
    with pytest.raises(ConfigError, match="no compiled gate file"):
        check_gate_file(deployment.model_copy(update={"profile": "hardware"}))


def test_of_a_gate_that_cannot_run_the_systems_reason_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "fairlead-safety").write_text("#!/bin/sh\nexec /no/loader\n")
    (tmp_path / "fairlead-safety").chmod(0o700)
    monkeypatch.setenv("FAIRLEAD_GATE_DIR", str(tmp_path))
    with pytest.raises(ConfigError, match=rf"^{tmp_path}/fairlead-safety: .*/no/loader: not found"):
        check_gate_file(load_deployment(deployment_path("panda_mujoco")))
