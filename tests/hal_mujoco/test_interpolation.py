"""Between the rows that the gate released: what the servos are told, at each physics step."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from bench.equipment.motion_log import MotionLog
from fairlead.deploy.registry import Registry
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray, SafeChunk, decode, floats
from fairlead.modes import ControlMode
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import rskill_dir
from fairlead.robot.executed_way import smoothed_changes
from fairlead.robot.interpolation import Interpolation
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Sample
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.cli.command import fairlead_here
from tests.hal_mujoco.joint_reach import SKILL, SOURCE
from tests.shape.own_robot import NAME, own_robot

ARM = tuple(range(7))
REACH = "mine-joint-reach"
MOST = np.array(list(smoothed_changes(load_robot("panda"), "sim").values())[: len(ARM)])
STEPS = 25  # physics steps of 2 ms in a period: a drive of 500 Hz


@contextmanager
def told_servos() -> Iterator[list[FloatArray]]:
    """Every physics step's setpoints of the arm, as MuJoCo's own callback sees them."""
    told: list[FloatArray] = []
    mujoco.set_mjcb_control(lambda _model, data: told.append(data.ctrl[list(ARM)].copy()))
    try:
        yield told
    finally:
        mujoco.set_mjcb_control(None)


def drive(interpolation: Interpolation, rows: FloatArray) -> FloatArray:
    """What the servos were told, ``[row, step, joint]``, while these rows acted."""
    robot = load_robot("panda").model_copy(update={"interpolation": interpolation})
    backend = MujocoBackend(robot)
    with told_servos() as told:
        for row in rows:
            command = PartCommand(ControlMode.JOINT_POSITION, "", np.append(row, 0.0), ARM)
            backend.apply({"arm": command})
    return np.array(told).reshape(len(rows), STEPS, len(ARM))


def walk(start: FloatArray) -> FloatArray:
    """Rows to and fro at the largest step that the gate admits, with changes that are smoothed."""
    rng = np.random.default_rng(1)
    steps = 0.055 * np.sin(np.linspace(0.0, 9.0, 40))[:, None] * rng.uniform(-1.0, 1.0, len(ARM))
    return np.vstack([start, start + np.cumsum(steps, axis=0)])


@pytest.mark.simulator
def test_a_drive_of_500_hz_is_told_the_gates_straight_way_or_the_spline_beside_it() -> None:
    start = MujocoBackend(load_robot("panda")).read().positions[: len(ARM)]
    rows = walk(start)
    linear, spline = drive("linear", rows), drive("cubic_b_spline", rows)
    places = np.arange(1, STEPS + 1)[:, None] / STEPS
    for told, (before, row) in zip(linear[1:], pairwise(rows), strict=True):
        np.testing.assert_allclose(told, before + places * (row - before), rtol=0, atol=1e-12)
    change = np.abs(np.diff(rows, 2, axis=0)).max()
    for told, (before, row) in zip(spline[2:], pairwise(rows[:-1]), strict=True):
        way = before + places * (row - before)  # a period later
        assert np.abs(told - way).max() <= change / 6.0 + 1e-12
    jumps = [np.abs(np.diff(told.reshape(-1, len(ARM)), 2, axis=0)) for told in (linear, spline)]
    assert jumps[1].max() < jumps[0].max() / 10.0, "the velocity of linear setpoints leaps"


def mine(folder: Path, monkeypatch: pytest.MonkeyPatch, interpolation: str) -> Path:
    """A panda of one's own with that interpolation, its skill; returns a deployment of it."""
    robots, skills = folder / "robots", folder / "rskills"
    told = ("base_frame:", f"interpolation: {interpolation}\nbase_frame:")
    own_robot(robots, monkeypatch, yaml=told)
    assert fairlead_here("robot", "compile", NAME, state=folder).returncode == 0
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(skills))
    (skills / REACH).mkdir(parents=True)
    text = (rskill_dir(SKILL) / "rskill.yaml").read_text()
    text = text.replace(f"id: {SKILL}", f"id: {REACH}").replace("[panda]", f"[{NAME}]", 1)
    (skills / REACH / "rskill.yaml").write_text(text)
    source = folder / "mine.yaml"
    source.write_text(SOURCE.read_text().replace("robot: panda ", f"robot: {NAME} "))
    return source


@pytest.mark.processes
@pytest.mark.parametrize("interpolation", ["linear", "cubic_b_spline"])
def test_released_rows_and_nothing_else_become_setpoints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, interpolation: str
) -> None:
    source = mine(tmp_path, monkeypatch, interpolation)
    options: dict[str, dict[str, Any]] = {"runner": {"skills": [REACH]}, "hal": {"trace": True}}
    scratch = make_scratch(source, tmp_path / "state", ScratchOptions(options=options))
    released: dict[int, FloatArray] = {}

    def on_safe(sample: Sample) -> None:
        chunk = decode(SafeChunk, sample.payload)
        arm = next(part for part in chunk.parts if part.part == 0)
        released[chunk.verdict_id] = floats(arm.values).reshape(chunk.horizon, -1)[:, : len(ARM)]

    with scratch_robot(scratch, Registry(tmp_path / "registry")) as robot:
        robot.client.bus.subscribe(robot.client.keys.every_safe, on_safe)
        robot.client.arm()
        result = run_goal(robot.client, GoalOptions(REACH)).result
    assert result is not None and result.outcome == "succeeded", result

    lines = {line.tick: line.rows[0] for line in MotionLog(tmp_path / "state/hal").read()}
    rows = {tick: released[by][row] for tick, (by, row) in lines.items() if by in released}
    trace = (tmp_path / "state/hal/trace.jsonl").read_text(encoding="utf-8")
    compared = 0
    for line in map(json.loads, trace.splitlines()):
        newest = [line["tick"] - late for late in (2, 1, 0)]
        if not rows.keys() >= set(newest):
            continue
        first, middle, last = (rows[tick] for tick in newest)
        corner = np.clip(first - 2.0 * middle + last, -MOST, MOST) / 6.0
        wanted = last if interpolation == "linear" else middle + corner
        told = np.frombuffer(bytes.fromhex(line["packed"]), np.float32)[: len(ARM)]
        np.testing.assert_allclose(told, wanted, rtol=0, atol=1e-6)
        compared += 1
    assert compared > 10
