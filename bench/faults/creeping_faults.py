"""Streams of small steps that lead where none may: the gate ends each before the breach."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bench.equipment.gate_scene import Scene
from bench.faults.arm_model import ArmModel
from bench.faults.gate_stage import GateStage, Stopwatch
from bench.faults.row import Row, Shot
from fairlead.messages import ActionChunk, FloatArray, Outcome, Verdict, pack_floats
from fairlead.modes import ControlMode
from fairlead.paths import gate_config
from fairlead.robot.gate_file import sealed
from fairlead.robot.manifest import load_robot

ROWS_A_CHUNK, STEPS = 4, 400
STEP_RAD, STEP_M = 0.02, 0.02
ROOM_M = 0.1
SMALLEST_SINGULAR = 0.05
REALISED = 0.25
ELBOW = ("panda_link4", "panda_link5")


def changed_gate_file(folder: Path, robot: str, changes: Mapping[str, Any]) -> Path:
    """The robot's gate file for the simulator with other values at its top level."""
    content = json.loads(gate_config(robot, "sim").read_text()) | dict(changes)
    file = folder / f"{robot}.json"
    file.write_text(sealed(json.dumps(content)), encoding="utf-8")
    return file


def creep(
    scene: Scene, next_chunk: Callable[[], ActionChunk], execute: Callable[[], None]
) -> tuple[Verdict, int]:
    """Small steps, each executed exactly, until one is refused; how many were executed."""
    for step in range(STEPS):
        verdict = scene.send(next_chunk())
        if verdict.outcome == Outcome.REFUSED:
            return verdict, step
        execute()
        scene.acted_on(verdict, 0)
    raise AssertionError(f"{STEPS} steps, none refused")


class JointCreep:
    """An arm that takes joint targets and turns one joint, step by step."""

    def __init__(self, scene: Scene, joint: int) -> None:
        self._scene = scene
        self._own = tuple(scene.hal.joints.index(name) for name in scene.hal.parts["arm"])
        self._turning = self._own[joint]

    def chunk(self) -> ActionChunk:
        hal = self._scene.hal
        values = np.zeros((ROWS_A_CHUNK, len(hal.joints)))
        values[:, self._own] = hal.positions[list(self._own)]
        values[:, self._turning] += STEP_RAD * np.arange(1, ROWS_A_CHUNK + 1)
        part = self._scene.arm_part(
            mode=ControlMode.JOINT_POSITION, frame_id="", values=pack_floats(values),
            active=self._own,
        )  # fmt: skip
        return self._scene.chunk(rows=ROWS_A_CHUNK, parts=(part,))

    def execute(self) -> None:
        self._scene.hal.positions[self._turning] += STEP_RAD


def box_edge(stage: GateStage) -> Shot:
    """The arm turns its tool sideways, towards the side of the box that keeps it in."""
    model = ArmModel(load_robot("panda"), "panda_hand_tcp")
    with stage.scene(robot="panda") as scene:
        start = model.tool(scene.hal.positions)
    upper = [5.0, float(start[1]) + ROOM_M, 5.0]
    box = {"name": "box", "kind": "keep_in", "lower": [-5.0, -5.0, -5.0], "upper": upper}
    changes = {"workspace": {"volumes": [box], "source": "test"}}
    watch = Stopwatch()
    with stage.ready("panda", changed_gate_file(stage.folder, "panda", changes)) as scene:
        arm, reached = JointCreep(scene, 0), [start[1]]

        def execute() -> None:
            arm.execute()
            reached.append(model.tool(scene.hal.positions)[1])
            assert reached[-1] <= upper[1], f"breach: {reached[-1]} m, edge {upper[1]} m"

        verdict, steps = creep(scene, arm.chunk, execute)
    assert verdict.code == 31, verdict
    assert reached[-1] > start[1] + ROOM_M / 4, "the gate ended it far too early"
    left_mm = 1e3 * (upper[1] - reached[-1])
    return watch.shot(f"G031 after {steps} steps, {left_mm:.0f} mm before the edge", timed=False)


def into_the_table(stage: GateStage) -> Shot:
    """The arm leans forward until its elbow would be in a table beneath it."""
    model = ArmModel(load_robot("panda"), "panda_hand_tcp")
    capsules = json.loads(gate_config("panda", "sim").read_text())["collision"]["capsules"]
    elbow = [one for one in capsules if one["link"] in ELBOW]
    assert elbow, f"no capsules of {ELBOW}"
    with stage.scene(robot="panda") as scene:
        rest = scene.hal.positions.copy()
    table = table_below(model, rest, elbow)
    everywhere = {"name": "all", "kind": "keep_in", "lower": [-5.0] * 3, "upper": [5.0] * 3}
    changes = {"workspace": {"volumes": [everywhere, table], "source": "test"}}
    watch = Stopwatch()
    with stage.ready("panda", changed_gate_file(stage.folder, "panda", changes)) as scene:
        arm, depths = JointCreep(scene, 1), [model.depth(rest, elbow, table)]

        def execute() -> None:
            arm.execute()
            depths.append(model.depth(scene.hal.positions, elbow, table))
            assert depths[-1] <= 0.0, f"breach: {depths[-1]} m inside the table"

        verdict, steps = creep(scene, arm.chunk, execute)
    assert verdict.code == 31, verdict
    note = f"G031 after {steps} steps, {-1e3 * depths[-1]:.0f} mm above the table"
    return watch.shot(note, timed=False)


def table_below(model: ArmModel, rest: FloatArray, elbow: Any) -> dict[str, Any]:
    """A table whose top is `ROOM_M` below the elbow's lowest point."""
    table: dict[str, Any] = {
        "name": "table", "kind": "keep_out", "lower": [-1.0, -1.0, -1.0], "upper": [0.4, 1.0, 1.0],
    }  # fmt: skip
    while model.depth(rest, elbow, table) > -ROOM_M:
        table["upper"][2] -= 0.01
    table["lower"][0] = 0.15  # not where the arm itself stands
    return table


def towards_singularity(stage: GateStage) -> Shot:
    """Deltas stretch the arm outwards; a quarter of each happens, as in the simulator."""
    robot = load_robot("panda_mobile")
    content = json.loads(gate_config(robot.id, "sim").read_text())
    [arm] = [part for part in content["parts"] if part["name"] == "arm"]
    arm["singularity_limit"] = SMALLEST_SINGULAR
    model = ArmModel(robot, arm["tool_frame"])
    file = changed_gate_file(stage.folder, robot.id, {"parts": content["parts"]})
    watch = Stopwatch()
    with stage.ready(robot.id, file) as scene:
        names = tuple(arm["joints"])
        own = [scene.hal.joints.index(name) for name in names]
        motion = np.array([STEP_M, 0.0, 0.0, 0.0, 0.0, 0.0])
        smallest = [np.inf]

        def chunk() -> ActionChunk:
            values = pack_floats(np.tile(motion, (ROWS_A_CHUNK, 1)))
            return scene.chunk(
                rows=ROWS_A_CHUNK, parts=(scene.arm_part(ROWS_A_CHUNK, values=values),)
            )

        def execute() -> None:
            jacobian = model.jacobian(scene.hal.positions, names)
            scene.hal.positions[own] += REALISED * np.linalg.pinv(jacobian) @ motion
            after = model.jacobian(scene.hal.positions, names)
            smallest.append(float(np.linalg.svd(after, compute_uv=False)[-1]))
            assert smallest[-1] >= SMALLEST_SINGULAR, f"breach: {smallest[-1]}"

        verdict, steps = creep(scene, chunk, execute)
    assert verdict.code == 33, verdict
    return watch.shot(
        f"G033 after {steps} steps, smallest singular value {smallest[-1]:.3f}, "
        f"limit {SMALLEST_SINGULAR}", timed=False,
    )  # fmt: skip


ENDED = "refused or truncated; no executed state breaches"
ROWS = (
    Row(35, "steps creep to the edge of the box", ENDED, None, "gate", box_edge),
    Row(35, "steps lead the elbow into a table", ENDED, None, "gate", into_the_table),
    Row(35, "deltas stretch the arm into a singularity", ENDED, None, "gate", towards_singularity),
)
