"""A new skill's wave, judged by the real gate: joints do at once what its rows say."""

from __future__ import annotations

import runpy
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import yaml

from bench.equipment.case import Case, Chunk, Measured, PartRows, still
from bench.equipment.core_gate import HELD, CoreGate
from fairlead.messages import Acted, ActionPart, FloatArray, Verdict, floats
from fairlead.modes import ControlMode
from fairlead.policy import Observation
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import SkillManifest, read_skill
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner import fitted
from fairlead_skill_runner.candidate import dispatch
from fairlead_tools.skills.skeleton import skill_skeleton

TICK, CHUNKS = 100, 6
_BENT = {"kinova3": {"joint_2": 0.6, "joint_4": 1.9}}
"""Where robots without a home of their own start: their tools' reach ends above them [rad]."""


def written_skill(folder: Path, robot: RobotManifest, mode: str) -> SkillManifest:
    """What `skill new` writes, which its robot admits."""
    folder.mkdir()
    for file, text in skill_skeleton(folder.name, robot, mode).items():
        (folder / file).write_text(text, encoding="utf-8")
    skill = read_skill(folder)
    assert admission_problems(skill, robot) == []
    return skill


@contextmanager
def _gate(folder: Path, robot: RobotManifest) -> Iterator[CoreGate]:
    file = folder / "gate.sim.json"
    file.write_text(compile_gate_config(robot, "sim"), encoding="utf-8")
    gate = CoreGate(file)
    try:
        yield gate
    finally:
        gate.close()


def waved(
    folder: Path, robot: RobotManifest, skill: SkillManifest
) -> tuple[list[Verdict], FloatArray]:
    """What the gate said of each chunk, and where the commanded joints were ``[ticks, joints]``."""
    at = np.array([_start(robot, joint) for joint in (*robot.joints, *robot.passive_joints)])
    seen = [
        robot.measured_joint_names.index(name)
        for field in skill.state_contract.joints
        for name in field.names
    ]
    document = yaml.safe_load((folder / skill.id / "rskill.yaml").read_text(encoding="utf-8"))
    make = runpy.run_path(str(folder / skill.id / "policy.py"))["Policy"].from_options
    policy = make(None, document["policy"]["options"]["options"])
    routes, said, way, tick = resolve_routes(skill.action_contract, robot), [], [at.copy()], TICK
    with _gate(folder, robot) as gate:
        state = still(tick, at)
        gate.start("lockstep", state)
        told = tuple(route.part_name for route in routes)
        gate.claim(Case(robot.id, "lockstep", state, Chunk(tick, 1, ())), parts=told)
        for _ in range(CHUNKS):
            actions = policy.infer(Observation(tick, at[seen], ""))
            (part,) = dispatch(routes, fitted(routes, actions), actions.shape[1])
            rows = floats(part.values).reshape(len(actions), -1)
            chunk = PartRows(part.part, part.mode, rows, part.frame_id, tuple(part.active))
            said.append(gate.send(Chunk(tick, len(rows), (chunk,)), tick).verdict)
            for index, row in enumerate(rows):
                before, at = at, _moved(at, part, row, robot)
                tick += 1
                way.append(at)
                speed = (at - before) / (robot.tick_period_ns * 1e-9)
                acted = [HELD] * len(robot.parts)
                acted[part.part] = Acted(hold=0, verdict_id=said[-1].verdict_id, row=index)
                gate.state(Measured(tick, at, speed, np.zeros(len(at))), tuple(acted))
    return said, np.array(way)[:, : robot.n_dof]


def _start(robot: RobotManifest, joint: Joint) -> float:
    middle = 0.5 * (joint.lower + joint.upper) if joint.has_bounds else 0.0
    bent = _BENT.get(robot.id, {}) if robot.home is None else robot.home.positions
    return bent.get(joint.name, middle)


def _moved(at: FloatArray, part: ActionPart, row: FloatArray, robot: RobotManifest) -> FloatArray:
    at, active = at.copy(), list(part.active)
    if part.mode == ControlMode.JOINT_POSITION:
        at[active] = row[active]
    else:
        at[active] += row[active] * robot.tick_period_ns * 1e-9
    return at
