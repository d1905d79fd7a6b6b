"""``fairlead why`` for changes that a robot does not declare: which mode after which (G025)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.gate_scene import Scene
from bench.equipment.running_gate import ROBOT
from fairlead.messages import ActionPart, Outcome, pack_floats
from fairlead.modes import ControlMode
from fairlead.paths import gate_config
from fairlead.robot.gate_file import sealed
from tests.cli.command import fairlead_here as fairlead

pytestmark = pytest.mark.processes

BASE, COMPOSITE = 2, 3


def action(part: int, mode: ControlMode, *rows: list[float]) -> ActionPart:
    frame = "base_link" if mode == ControlMode.BODY_TWIST else ""
    active = (0, 1, 2) if mode == ControlMode.JOINT_VELOCITY else ()
    values = pack_floats(np.array(rows))
    return ActionPart(part=part, mode=mode, frame_id=frame, values=values, active=active)


def without_changes(folder: Path) -> Path:
    """The robot's gate file with no transition, and a switch that turns at standstill only."""
    file = json.loads(gate_config(ROBOT, "sim").read_text())
    for part in file["parts"]:
        part["transitions"] = []
        if "composite_mode" in part["modes"]:
            part["modes"]["composite_mode"]["switching"] = "at_standstill"
    path = folder / "gate.changes.json"
    path.write_text(sealed(json.dumps(file)))
    return path


def test_a_change_that_is_not_declared_is_told_by_its_modes_and_no_number(tmp_path: Path) -> None:
    scene = Scene(without_changes(tmp_path), tmp_path)
    try:
        scene.meet_hal()
        scene.arm()
        scene.take_claim("arm", "base", "composite")
        speed = action(BASE, ControlMode.JOINT_VELOCITY, [0.0] * 11)
        scene.acted_on(scene.send(scene.chunk(rows=1, parts=(speed,))), 0, ("base",))
        changed_at = scene.hal.tick
        twist = action(BASE, ControlMode.BODY_TWIST, [0.0] * 6)
        assert scene.send(scene.chunk(rows=1, parts=(twist,))).outcome == Outcome.REFUSED
        turned_at = scene.next_tick(scene.hal.held())
        turn = action(COMPOSITE, ControlMode.COMPOSITE_MODE, [-1.0], [1.0])
        assert scene.send(scene.chunk(rows=2, parts=(turn,))).outcome == Outcome.TRUNCATED
        scene.silence()
        assert scene.gate.stop() == 0
    finally:
        scene.close()

    def why(tick: int) -> str:
        words = ("why", str(tick), "--log", str(tmp_path / "decisions"))
        done = fairlead(*words, state=tmp_path / "registry")
        assert done.returncode == 0, done.stderr
        return str(done.stdout)

    said = why(changed_at)
    assert (
        "why     G025 mode switch not allowed: row 0, base mode body_twist after joint_velocity, "
        "needs a change in its transitions\n"
    ) in said
    assert "hold until the robot stands still; `transitions` and `switching` in" in said
    assert "passes" not in said
    said = why(turned_at)
    assert (
        "why     G025 mode switch not allowed: row 1, composite composite, needs a first row, "
        "and standstill\n"
    ) in said
