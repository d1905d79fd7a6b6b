"""Rows of one part as they go into a chunk, from numbers in the units of its mode."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.messages import ActionPart, FloatArray, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead.skill.slots import FIELD_RULES


def part_rows(
    robot: RobotManifest,
    part: str,
    mode: ControlMode,
    rows: npt.ArrayLike,
    *,
    frame: str = "",
    joints: Sequence[str] = (),
) -> ActionPart:
    """What one part is told, one row a tick.

    Args:
        rows: ``[H, width]`` in SI; a joint mode's rows are as wide as its ``joints``.
        frame: of a cartesian mode, whose axes these are; no other mode has one.
        joints: of a joint mode, in the order of the columns; (): all joints of the part.

    Raises:
        ConfigError: the robot has no such part, mode, joint or frame, or the rows do not fit.
    """
    if part not in robot.part_names:
        raise ConfigError(expected(f"robot {robot.id}", "a part", repr(part), robot.part_names))
    index = robot.part_names.index(part)
    declared = robot.parts[index]
    modes = [one for one in declared.control_modes if one in FIELD_RULES]
    if mode not in modes or not isinstance(mode, ControlMode):
        got = mode.yaml_name if isinstance(mode, ControlMode) else f"{mode!r}, no ControlMode"
        valid = [one.yaml_name for one in modes]
        raise ConfigError(expected(f"part {part}", "one of its modes", got, valid))
    columns = _columns(robot, declared, mode, joints)
    values = _checked(part, mode, rows, len(columns) or mode.width(robot.n_dof))
    if columns:
        wire = np.zeros((len(values), robot.n_dof))
        wire[:, columns] = values
        values = wire
    return ActionPart(
        part=index,
        mode=int(mode),
        frame_id=_frame(robot, part, mode, frame),
        values=pack_floats(values),
        active=tuple(sorted(columns)),
    )


def _columns(
    robot: RobotManifest, part: Part, mode: ControlMode, joints: Sequence[str]
) -> list[int]:
    """Where a joint mode's numbers stand on the wire; none for another mode."""
    valid = part.joints if mode.is_joint_mode else ()
    for name in joints:
        if name not in valid:
            what = f"a joint for {mode.yaml_name}" if valid else f"no joints for {mode.yaml_name}"
            raise ConfigError(expected(f"part {part.name}", what, repr(name), valid))
        if list(joints).count(name) > 1:
            raise ConfigError(expected(f"part {part.name}", "each joint once", list(joints)))
    return [robot.joint_names.index(name) for name in joints or valid]


def _checked(part: str, mode: ControlMode, rows: npt.ArrayLike, width: int) -> FloatArray:
    what = f"rows [H >= 1, {width}] of numbers for {mode.yaml_name}"
    try:
        values = np.asarray(rows, dtype="<f8")
    except (TypeError, ValueError):
        raise ConfigError(expected(f"part {part}", what, "rows of other things")) from None
    if values.ndim != 2 or not len(values) or values.shape[1] != width:
        raise ConfigError(expected(f"part {part}", what, list(values.shape)))
    for row, column in np.argwhere(~np.isfinite(values)):
        got = f"{values[row, column]} in row {row}, column {column}"
        raise ConfigError(expected(f"part {part}", f"finite numbers for {mode.yaml_name}", got))
    return values


def _frame(robot: RobotManifest, part: str, mode: ControlMode, frame: str) -> str:
    wants = "frame" in FIELD_RULES[mode].required
    if wants != bool(frame):
        what = f"the frame of its {mode.yaml_name}" if wants else f"no frame for {mode.yaml_name}"
        raise ConfigError(expected(f"part {part}", what, repr(frame) if frame else "none"))
    return robot.base_frame if mode is ControlMode.BODY_TWIST else frame
