"""Grippers open when told to; a base drives along the axes that its commands are declared in."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.safety_profile import profile_limits
from fairlead_tools.conformance.row import Check, Row
from fairlead_tools.conformance.stage import Stage
from fairlead_tools.measure.driven_robot import Moment

MOST_ROWS = 64
TARGETS = (0.35, 0.65, 0.35)
"""Where a gripper is told to go, in shares of its range."""
LEAST = 0.4
"""Of what it was told: a gripper that made less did not go there."""
TURN_RAD = 0.8
"""Friction takes the same of both slides there, about."""
TURNS = 3
NEAR_RAD = 0.15
CLEAR = 1.5
"""A slide's step, in dead bands."""
OFF_RAD = 0.2
DRIVE_ROWS = 8
GRIPPER = Check(
    "gripper way", "told to open, it opens; told to close, it closes",
    "robot.yaml: lower, upper of its mode", "total opening in m, or the angle of its joint in rad",
)  # fmt: skip
GRIPPER_PLACE = Check(
    "gripper place", "near its target", "robot.yaml: slip_limit, tolerance",
    "total opening in m, or the angle of its joint in rad",
)  # fmt: skip
BASE = Check(
    "base command frame", "x drives along x of the declared frame",
    "robot.yaml: base.command_frame; body_twist: base_link",
    "turn the command into that frame, or declare base.command_frame as it is",
)  # fmt: skip


def gripper_checks(stage: Stage) -> Iterator[Row]:
    """Every gripper mode of every part."""
    none = True
    for part, modes in stage.modes.items():
        for mode in modes:
            if mode.is_gripper_mode:
                none = False
                yield from _gripper(stage, part, mode)
    if none:
        yield GRIPPER.not_checked("no part has a gripper mode")


def _gripper(stage: Stage, part: str, mode: ControlMode) -> Iterator[Row]:
    [index] = stage.joints_of(part)
    joint = stage.robot.joints[index]
    places = _places(stage, part, mode)
    speed = profile_limits(joint, stage.profile)[0]
    stroke = abs(places[1][1] - places[0][1])
    count = min(MOST_ROWS, 8 + math.ceil(2.0 * stroke / speed / stage.period_s))
    found, told = list[float](), list[float]()
    way = replace(GRIPPER, of=f"{part} {mode.yaml_name}")
    for value, place in places:
        command = PartCommand(mode, "", np.array([value]), ())
        run = stage.execute(partial(_same, {part: command}, count))
        if not run.acted_all:
            yield way.row([f"rows did not act: {run.story}"], "")
            return
        found.append(float(stage.states.newest.positions[index]))
        told.append(place)
    went = ", ".join(f"told {one:.3g}: {at:.3g}" for one, at in zip(told, found, strict=True))
    least = LEAST * stroke
    is_right = found[1] - found[0] > least and found[1] - found[2] > least
    yield way.row([] if is_right else [f"{went} {joint.unit}"], f"{went} {joint.unit}")
    yield _place(stage, part, mode, np.abs(np.array(found) - told)[1:])


def _same(row: dict[str, PartCommand], count: int, now: Moment) -> list[dict[str, PartCommand]]:
    return [row] * count


def _places(stage: Stage, part: str, mode: ControlMode) -> list[tuple[float, float]]:
    """What it is told, and where that is [rad or m]."""
    joint = stage.robot.joints[stage.joints_of(part)[0]]
    if mode is ControlMode.GRIPPER_BINARY:
        return [(1.0, joint.lower), (0.0, joint.upper), (1.0, joint.lower)]
    limits = stage.limits(part, mode)
    at = [limits.lower + share * (limits.upper - limits.lower) for share in TARGETS]
    return [(one, one) for one in at]


def _place(stage: Stage, part: str, mode: ControlMode, errors: FloatArray) -> Row:
    [index] = stage.joints_of(part)
    joint = stage.robot.joints[index]
    slip = None
    if mode is ControlMode.GRIPPER_POSITION:
        limits = stage.limits(part, mode)
        slip = getattr(limits, f"slip_limit_{limits.unit}")
    check = replace(GRIPPER_PLACE, of=f"{part} {mode.yaml_name}")
    if slip is None:
        return check.not_checked("slip_limit is null: robot.yaml does not say how near it comes")
    bound = slip + (stage.profile.measured[joint.name].tolerance or 0.0)
    check = replace(check, expected=f"within {bound:.3g} {joint.unit} of its target")
    got = f"{errors.max():.3g} {joint.unit}"
    return check.row([got] if errors.max() > bound else [], got)


def base_checks(stage: Stage) -> Iterator[Row]:
    """X alone, at a yaw that tells frames apart."""
    base = stage.robot.base_joints
    part = stage.robot.owner(base[0]).name if len(base) == 3 else ""
    driving = (ControlMode.JOINT_VELOCITY, ControlMode.BODY_TWIST)
    modes = [one for one in stage.modes.get(part, ()) if one in driving]
    if not modes:
        yield BASE.not_checked("no part drives a base")
        return
    if stage.profile.base is None:
        yield BASE.not_checked("the profile declares no base")
        return
    for mode in modes:
        _turn(stage, part, mode, TURN_RAD)
        yield _drive(stage, part, mode)
        _turn(stage, part, mode, 0.0)


def _turn(stage: Stage, part: str, mode: ControlMode, goal: float) -> None:
    """To a yaw [rad], as near as a few tries come."""
    yaw = stage.robot.joint_names.index(stage.robot.base_joints[2])
    axis = stage.joints_of(part).index(yaw) if mode.is_joint_mode else 5
    pace = max(stage.share, 0.3)
    step = pace * profile_limits(stage.robot.joints[yaw], stage.profile)[0] * stage.period_s
    for _ in range(TURNS):
        away = goal - float(stage.states.newest.positions[yaw])
        if abs(away) < NEAR_RAD:
            return
        count = min(MOST_ROWS, math.ceil(abs(away) / step))
        _go(stage, part, mode, axis, math.copysign(pace, away), count)


def _go(
    stage: Stage, part: str, mode: ControlMode, axis: int, wish: float, count: int
) -> tuple[Moment, Moment] | None:
    """One axis for a while; before and after. None: the rows did not act."""

    def make(now: Moment) -> list[dict[str, PartCommand]]:
        maker = stage.rows(part, mode, now)
        vector = np.zeros(maker.axes)
        vector[axis] = wish
        return [{part: maker.row(vector, now)} for _ in range(count)]

    run = stage.execute(make)
    before = stage.moment(run.sent.first)
    stage.settle()
    return (before, stage.moment(stage.states.newest_tick)) if run.acted_all else None


def _speed_of(stage: Stage, part: str, mode: ControlMode) -> float:
    """The fastest that x is told [m/s]."""
    if mode is ControlMode.BODY_TWIST:
        return float(stage.limits(part, mode).linear_limit_m_s) / math.sqrt(2.0)
    x = stage.robot.joint(stage.robot.base_joints[0])
    return profile_limits(x, stage.profile)[0]


def _drive(stage: Stage, part: str, mode: ControlMode) -> Row:
    assert stage.profile.base is not None, "checked before"
    joints = [stage.robot.joint_names.index(name) for name in stage.robot.base_joints]
    yaw = float(stage.states.newest.positions[joints[2]])
    frame = "base_link" if mode is ControlMode.BODY_TWIST else stage.profile.base.command_frame
    check = replace(BASE, of=f"{part} {mode.yaml_name}", expected=f"x drives along x of {frame}")
    if abs(yaw) < 2.0 * OFF_RAD:
        return check.not_checked(f"the base could not be turned: yaw {yaw:.2f} rad")
    axis = stage.joints_of(part).index(joints[0]) if mode.is_joint_mode else 0
    dead = CLEAR * float(stage.dead[joints[:2]].max()) / abs(math.sin(yaw))
    pace = min(1.0, max(stage.share, dead / (_speed_of(stage, part, mode) * stage.period_s)))
    gone = _go(stage, part, mode, axis, pace, DRIVE_ROWS)
    if gone is None:
        return check.row(["rows did not act"], "")
    before, after = gone
    if mode is ControlMode.BODY_TWIST:
        way, wanted = (after.base - before.base)[:2], float(before.base[2])
    else:
        way = (after.positions - before.positions)[joints[:2]]
        wanted = {"odom": 0.0, "against_yaw": -yaw}[frame]
    size, went = float(np.linalg.norm(way)), float(np.arctan2(way[1], way[0]))
    off = abs((went - wanted + math.pi) % (2.0 * math.pi) - math.pi)
    got = f"{size:.3g} m, {off:.2f} rad off at yaw {yaw:.2f}"
    return check.row([got] if size == 0.0 or off > OFF_RAD else [], got)
