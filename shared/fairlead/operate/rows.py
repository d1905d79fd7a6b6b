"""Rows of one part as they go into a chunk, from numbers in the units of its mode."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.messages import ActionPart, FloatArray, HalStatus, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead.skill.slots import FIELD_RULES

Offered = Mapping[str, Collection[ControlMode]]
"""Modes by part."""
_FLOAT_BYTES = 8


def part_rows(
    robot: RobotManifest,
    part: str,
    mode: ControlMode,
    rows: npt.ArrayLike,
    *,
    frame: str = "",
    joints: Sequence[str] = (),
    offered: Offered | None = None,
) -> ActionPart:
    """What one part is told, one row a tick.

    Args:
        rows: ``[H, width]`` in SI; a joint mode's rows are as wide as its ``joints``.
        frame: of a cartesian mode, whose axes these are; no other mode has one.
        joints: of a joint mode, in the order of the columns; (): all joints of the part.
        offered: what the running HAL can do; None: all that robot.yaml declares.

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
    if offered is not None:
        check_offered(part, mode, offered)
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


def offered_modes(hal: HalStatus) -> Offered:
    """What the running HAL can do, part by part: less, perhaps, than robot.yaml declares."""
    known = {int(mode): mode for mode in ControlMode}
    return {
        part.name: [known[one.mode] for one in part.ranges if one.mode in known]
        for part in hal.parts
    }


def check_offered(part: str, mode: ControlMode, offered: Offered) -> None:
    """Raises `ConfigError` if the HAL, which would stop the robot, cannot do this mode."""
    modes = offered.get(part, ())
    if mode not in modes:
        valid = [one.yaml_name for one in modes]
        raise ConfigError(
            expected(f"part {part}", "a mode that this HAL offers", mode.yaml_name, valid)
        )


def common_horizon(who: str, n_dof: int, parts: Sequence[ActionPart], most: int) -> int:
    """How many rows all parts of a chunk have.

    Raises:
        ConfigError: no parts made by `part_rows`, too many rows, or different horizons.
    """
    found = set[int]()
    for part in parts:
        if not isinstance(part, ActionPart):
            raise ConfigError(expected(who, "what `rows` made", type(part).__name__))
        is_known = part.mode in list(ControlMode) and isinstance(part.values, bytes)
        width = _FLOAT_BYTES * ControlMode(part.mode).width(n_dof) if is_known else 1
        if not is_known or len(part.values) % width:
            raise ConfigError(expected(who, "what `rows` made", "a part of other bytes or mode"))
        found.add(len(part.values) // width)
    if len(found) != 1:
        got = ", ".join(str(one) for one in sorted(found)) or "no parts"
        raise ConfigError(f"{who}: expected parts of one number of rows, got {got}")
    if (horizon := found.pop()) > most:
        raise ConfigError(expected(who, f"at most {most} rows", horizon))
    return horizon


def _columns(
    robot: RobotManifest, part: Part, mode: ControlMode, joints: Sequence[str]
) -> list[int]:
    """Where a joint mode's numbers stand on the wire; none for another mode."""
    valid = part.joints if mode.is_joint_mode else ()
    if not isinstance(joints, tuple | list):
        raise ConfigError(expected(f"part {part.name}", "joints in a tuple", repr(joints)))
    for name in joints:
        if name not in valid:
            what = f"a joint for {mode.yaml_name}" if valid else f"no joints for {mode.yaml_name}"
            raise ConfigError(expected(f"part {part.name}", what, repr(name), valid))
        if list(joints).count(name) > 1:
            raise ConfigError(expected(f"part {part.name}", "each joint once", list(joints)))
    return [robot.joint_names.index(name) for name in joints or valid]


def _checked(part: str, mode: ControlMode, rows: npt.ArrayLike, width: int) -> FloatArray:
    what = f"rows [H >= 1, {width}] of numbers for {mode.yaml_name}"
    if isinstance(rows, np.ma.MaskedArray):  # its masked numbers would come back to life
        raise ConfigError(expected(f"part {part}", what, "a masked array"))
    try:
        given = np.asarray(rows)
        values = np.asarray(given, dtype="<f8")
    except (TypeError, ValueError, OverflowError):
        raise ConfigError(expected(f"part {part}", what, "rows of other things")) from None
    if given.dtype.kind not in "fiu":
        raise ConfigError(expected(f"part {part}", what, f"rows of {given.dtype}"))
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
