"""What a row asked for and what came of it, in the row's own unit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead_tools.measure.driven_robot import DrivenRobot, Tick
from fairlead_tools.measure.rotations import angle_between, rotation_of
from fairlead_tools.record.measured import rotation_vector


@dataclass(frozen=True)
class Answer:
    """One half of one row (or one joint): told and moved, shape ``[1]`` to ``[3]``.

    what: ``linear``, ``angular`` or the joint's name. at: where in the row it stands. moved: of
    joints the measured velocity after the tick, of tools and bases the way they went in it.
    started_at: what was measured when the row began, in the same unit.
    """

    what: str
    at: slice
    told: FloatArray
    moved: tuple[FloatArray, ...]
    started_at: FloatArray


def answers(driven: DrivenRobot, part: str, tick: Tick) -> list[Answer]:
    """Told and moved in a mode that asks for motion."""
    command = tick.commands[part]
    if command.mode is ControlMode.JOINT_VELOCITY:
        return _joints(driven, command, tick)
    if command.mode is ControlMode.BODY_TWIST:
        moved, start = _base_ways(tick, driven.period_s)
    else:
        way, start = _tool_ways(driven, part, command, tick)
        moved = (way,)
    return [
        Answer(what, half, command.values[half], tuple(way[half] for way in moved), start[half])
        for what, half in (("linear", slice(0, 3)), ("angular", slice(3, 6)))
    ]


def distances(driven: DrivenRobot, part: str, tick: Tick) -> list[tuple[str, float]]:
    """How far each joint, or the tool, is from its target after the tick."""
    command = tick.commands[part]
    if command.mode is ControlMode.CARTESIAN_POSE:
        place, turn = tick.after.tools[part]
        return [
            ("linear", float(np.linalg.norm(command.values[:3] - place))),
            ("angular", angle_between(rotation_of(command.values[3:]), turn)),
        ]
    error = np.abs(command.values - tick.after.positions[: len(command.values)])
    return [(driven.robot.joint_names[joint], float(error[joint])) for joint in command.active]


def _joints(driven: DrivenRobot, command: PartCommand, tick: Tick) -> list[Answer]:
    return [
        Answer(
            driven.robot.joint_names[joint],
            slice(joint, joint + 1),
            command.values[[joint]],
            (tick.after.velocities[[joint]],),
            tick.before.velocities[[joint]],
        )
        for joint in command.active
    ]


def _tool_ways(
    driven: DrivenRobot, part: str, command: PartCommand, tick: Tick
) -> tuple[FloatArray, FloatArray]:
    """The tool's way along the root's axes by its own joints, and its measured twist before."""
    own, chain = driven.indices(part), driven.chains[part]
    names = driven.robot.part(part).joints
    jacobian = chain.jacobian(driven.named(tick.before.positions), names)
    start = jacobian @ tick.before.velocities[own]
    later = tick.before.positions.copy()
    later[own] = tick.after.positions[own]
    (place, turn) = chain.pose(driven.named(later))
    (from_place, from_turn) = tick.before.tools[part]
    moved = np.concatenate([place - from_place, rotation_vector(turn @ from_turn.T)])
    if command.mode is ControlMode.CARTESIAN_DELTA:
        return moved, start * driven.period_s
    return moved / driven.period_s, start


def _base_ways(tick: Tick, period_s: float) -> tuple[tuple[FloatArray, ...], FloatArray]:
    """Along base_link's axes as they were when the row began: of its origin, and of its slides.

    The joints 0 to 2 are x, y and yaw; the yaw axis is not at the origin.
    """
    yaw = tick.before.base[2]
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    ways = [
        np.array([*(turn @ way[:2]), 0.0, 0.0, 0.0, way[2]])
        for way in (
            (tick.after.base - tick.before.base) / period_s,
            (tick.after.positions - tick.before.positions)[:3] / period_s,
            tick.before.velocities[:3],
        )
    ]
    return (ways[0], ways[1]), ways[2]
