"""What was proposed, released and measured for each part, tick by tick. Pure functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from fairlead.messages import ActionPart, FloatArray, Hold, JointState, TransformBatch, floats
from fairlead.modes import ControlMode
from fairlead.record.recorder import Recording
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part

Curve = dict[int, float]
"""Value by tick."""


@dataclass
class Panel:
    """Three curves of one quantity of one part, in the unit of its title."""

    part: str
    quantity: str
    unit: str
    proposed: Curve = field(default_factory=dict)
    released: Curve = field(default_factory=dict)
    measured: Curve = field(default_factory=dict)


@dataclass(frozen=True)
class _Quantity:
    """One number of a mode's row, and the measured number to hold it against."""

    name: str
    unit: str
    of_row: Callable[[FloatArray], float]
    measured: Curve


def panels(recording: Recording, robot: RobotManifest, source: str) -> list[Panel]:
    """One panel for each quantity that ``source`` commanded, parts in robot order."""
    motion = _hand_motion(recording, robot)
    found: dict[tuple[int, str], Panel] = {}
    rows = [
        (chunk.start_tick, chunk.parts, "proposed")
        for chunk in recording.candidates
        if chunk.source == source
    ]
    rows += [
        (chunk.first_tick, chunk.parts, "released")
        for chunk in recording.safes
        if chunk.source == source
    ]
    for first_tick, parts, curve in rows:
        for part in parts:
            for quantity in _quantities(part, robot, recording.joints, motion):
                declared = robot.parts[part.part]
                panel = found.setdefault(
                    (part.part, quantity.name),
                    Panel(declared.name, quantity.name, quantity.unit, measured=quantity.measured),
                )
                width = ControlMode(part.mode).width(robot.n_dof)
                for offset, row in enumerate(floats(part.values, width)):
                    getattr(panel, curve)[first_tick + offset] = quantity.of_row(row)
    return [found[key] for key in sorted(found, key=lambda key: key[0])]


def held_ticks(recording: Recording) -> dict[int, Hold]:
    """Ticks in which every part held, and why the first one did."""
    return {
        state.tick - 1: Hold(state.acted[0].hold)
        for state in recording.joints
        if state.acted and all(one.hold != Hold.NONE for one in state.acted)
    }


def _quantities(
    part: ActionPart,
    robot: RobotManifest,
    joints: Iterable[JointState],
    motion: Mapping[str, tuple[Curve, Curve]],
) -> list[_Quantity]:
    mode, declared = ControlMode(part.mode), robot.parts[part.part]
    if mode is ControlMode.CARTESIAN_DELTA:
        moved, turned = motion.get(declared.name, ({}, {}))
        return [
            _Quantity("step", "mm per tick", lambda row: 1e3 * _norm(row[:3]), moved),
            _Quantity("turn", "mrad per tick", lambda row: 1e3 * _norm(row[3:]), turned),
        ]
    if mode is ControlMode.GRIPPER_POSITION:
        return [
            _Quantity(
                "opening", "mm", lambda row: 1e3 * float(row[0]), _opening(robot, declared, joints)
            )
        ]
    if mode.is_joint_mode:
        return [_joint_quantity(index, mode, robot, joints) for index in part.active]
    return [_Quantity(mode.yaml_name, "", lambda row: float(row[0]), {})]


def _joint_quantity(
    index: int, mode: ControlMode, robot: RobotManifest, joints: Iterable[JointState]
) -> _Quantity:
    joint = robot.joints[index]
    length = "m" if joint.type == "prismatic" else "rad"
    is_velocity = mode is ControlMode.JOINT_VELOCITY
    measured = {
        _acted_tick(state): float(
            floats(state.velocities if is_velocity else state.positions)[index]
        )
        for state in joints
    }
    unit = f"{length}/s" if is_velocity else length
    return _Quantity(joint.name, unit, lambda row: float(row[index]), measured)


def _acted_tick(state: JointState) -> int:
    """What a row of tick n leads to is the state at the start of tick n + 1."""
    return state.tick - 1


def _opening(robot: RobotManifest, part: Part, joints: Iterable[JointState]) -> Curve:
    tool = robot.end_effector(part.end_effector) if part.end_effector else None
    if tool is None or tool.gripper_joint is None:
        return {}
    index = robot.joint_names.index(tool.gripper_joint)
    return {_acted_tick(state): 1e3 * float(floats(state.positions)[index]) for state in joints}


def _hand_motion(recording: Recording, robot: RobotManifest) -> dict[str, tuple[Curve, Curve]]:
    """Per part with an end effector: how far its tool moved in the base, and turned."""
    curves = {}
    for part in robot.parts:
        if part.end_effector is not None:
            frame = robot.end_effector(part.end_effector).tool_frame
            curves[part.name] = _frame_motion(recording.transforms, robot.base_frame, frame)
    return curves


def _frame_motion(batches: Iterable[TransformBatch], base: str, frame: str) -> tuple[Curve, Curve]:
    poses: dict[int, tuple[FloatArray, FloatArray]] = {}
    for batch in batches:
        for transform in batch.transforms:
            if (transform.parent, transform.child) == (base, frame):
                poses[batch.tick] = floats(transform.translation), floats(transform.rotation_xyzw)
    moved, turned = {}, {}
    for tick, (position, rotation) in poses.items():
        if tick + 1 in poses:
            later_position, later_rotation = poses[tick + 1]
            moved[tick] = 1e3 * _norm(later_position - position)
            turned[tick] = 2e3 * float(np.arccos(np.clip(abs(rotation @ later_rotation), 0.0, 1.0)))
    return moved, turned


def _norm(vector: FloatArray) -> float:
    return float(np.linalg.norm(vector))
