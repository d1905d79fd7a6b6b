"""What a person can drive of a robot: the axes of one part, and how far a row may go along each.

Full speed is below the robot's own limits, so that ordinary driving is not refused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.mode_limits import BodyTwistMode, CartesianDeltaMode, JointPositionMode
from fairlead.robot.part import Part
from fairlead.robot.safety_profile import SafetyProfile
from fairlead_tools.teleop.grip import grips

SHARE = 0.8
"""Full speed, of what the gate lets pass in a row; the rest is for rounding and for norms."""
TOOL_M_S, TOOL_RAD_S = 0.25, 0.5
"""A tool led by hand is no faster: 250 mm/s is the reduced speed of ISO 10218-1."""
FOLLOWS = 0.9
"""Of the measuring tolerance, how far a target may be ahead of a joint beyond one step (G021)."""
NEARLY = 1.0 - 1e-9
"""Of that step: the sum of a position and a step is rounded."""
RAMP_S = 0.15
"""From rest to full speed, and back."""
XYZ, TURNS = ("x", "y", "z"), ("rx", "ry", "rz")
MODES = (ControlMode.JOINT_POSITION, ControlMode.CARTESIAN_DELTA, ControlMode.BODY_TWIST)
"""What can be driven by hand; of several that a part has, the first."""


@dataclass(frozen=True)
class Drive:
    """One part, told in one mode.

    Arrays are per axis, ``[n]``.

    Attributes:
        names: a joint's, or x, y, z [m], rx, ry, rz [rad] along the frame's axes.
        units: of a position along each axis, m or rad.
        columns: of the mode's row, in which each axis stands.
        width: numbers of a row as `PartClaim.rows` takes them.
        full: change per row at full speed; of ``body_twist`` the rate itself (per second).
        change: the most that the row's speed changes from row to row.
        lower, upper: position limits of joints; infinite where there are none.
        lead: how far a joint's target may be ahead of it.
    """

    part: str
    mode: ControlMode
    frame: str
    tool: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    columns: tuple[int, ...]
    width: int
    full: FloatArray
    change: FloatArray
    lower: FloatArray
    upper: FloatArray
    lead: FloatArray

    @property
    def is_position(self) -> bool:
        """Whether rows are targets; else they are speeds."""
        return self.mode is ControlMode.JOINT_POSITION

    def index(self, axis: str) -> int:
        """The axis of that name; `ConfigError` lists those there are."""
        if axis not in self.names:
            what = f"an axis of its {self.mode.yaml_name}"
            raise ConfigError(expected(f"part {self.part}", what, repr(axis), self.names))
        return self.names.index(axis)


def make_drive(
    robot: RobotManifest, profile: str, part: str = "", mode: str = "", axis: str = ""
) -> Drive:
    """What can be driven of a part.

    Args:
        part: "": the first that can be driven, and has the axis if there is one.
        mode: a control mode, "": the first of `MODES` that the part has, and that has the axis.
        axis: a joint, or x, y, z, rx, ry, rz; "": any.

    Raises:
        ConfigError: no such part, mode or axis; it says which there are.
    """
    chosen = [robot.part(part)] if part else [one for one in robot.parts if not grips(robot, one)]
    limits = robot.profile(profile)
    found = [
        _drive(robot, limits, one, each)
        for one in chosen
        for each in MODES
        if each.yaml_name in limits.parts[one.name].names and mode in ("", each.yaml_name)
    ]
    fitting = [drive for drive in found if not axis or axis in drive.names]
    if fitting:
        return fitting[0]
    who = f"part {part}" if part else f"robot {robot.id}"
    if axis and found:
        valid = list(dict.fromkeys(name for drive in found for name in drive.names))
        raise ConfigError(expected(who, "a joint or an axis", repr(axis), valid))
    if not found and part and grips(robot, chosen[0]):
        raise ConfigError(
            expected(who, "an arm or a base", "a gripper")
            + ": fairlead teleop opens and closes it beside its arm, and a skill does"
        )
    valid = [
        one.yaml_name
        for one in MODES
        if any(one.yaml_name in limits.parts[each.name].names for each in chosen)
    ]
    raise ConfigError(expected(who, "a mode to drive by hand", repr(mode or "none"), valid))


def _drive(robot: RobotManifest, limits: SafetyProfile, part: Part, mode: ControlMode) -> Drive:
    block = getattr(limits.parts[part.name], mode.yaml_name)
    if isinstance(block, JointPositionMode):
        return _joints(robot, limits, part, block)
    if isinstance(block, CartesianDeltaMode):
        return _tool(robot, part, block)
    assert isinstance(block, BodyTwistMode)
    return _base(robot, part, block)


def _joints(
    robot: RobotManifest, limits: SafetyProfile, part: Part, block: JointPositionMode
) -> Drive:
    joints = [robot.joint(name) for name in part.joints]
    period_s = robot.tick_period_ns * 1e-9
    full = SHARE * np.array(block.step_limits)
    tightest = [
        (limits.tighter_joints[one.name].acceleration_per_s2 if one.name in limits.tighter_joints
         else None) or one.acceleration_limit
        for one in joints
    ]  # fmt: skip
    tolerance = [limits.measured[one.name].tolerance or 0.0 for one in joints]
    return Drive(
        part=part.name,
        mode=ControlMode.JOINT_POSITION,
        frame="",
        tool="",
        names=part.joints,
        units=tuple(one.unit for one in joints),
        columns=tuple(range(len(joints))),
        width=len(joints),
        full=full,
        change=np.minimum(_ramp(full, period_s), SHARE * np.array(tightest) * period_s**2),
        lower=np.array([one.lower if one.has_bounds else -math.inf for one in joints]),
        upper=np.array([one.upper if one.has_bounds else math.inf for one in joints]),
        lead=NEARLY * np.array(block.step_limits) + FOLLOWS * np.array(tolerance),
    )


def _tool(robot: RobotManifest, part: Part, block: CartesianDeltaMode) -> Drive:
    period_s, most = robot.tick_period_ns * 1e-9, block.gain[1]
    linear = min(SHARE * block.linear_limit_m, TOOL_M_S * period_s / most)
    angular = min(SHARE * block.angular_limit_rad, TOOL_RAD_S * period_s / most)
    full = np.array([linear] * 3 + [angular] * 3)
    steps = [block.linear_step_limit_m] * 3 + [block.angular_step_limit_rad] * 3
    tool = robot.end_effector(part.end_effector).tool_frame if part.end_effector else ""
    axes = XYZ + TURNS if len(part.joints) >= len(XYZ + TURNS) else XYZ  # fewer cannot turn it too
    columns = tuple(range(len(axes)))
    frame = block.frames[0]
    return _speeds(robot, part, ControlMode.CARTESIAN_DELTA, frame, tool, full, steps, columns)


def _base(robot: RobotManifest, part: Part, block: BodyTwistMode) -> Drive:
    full = np.array([SHARE * block.linear_limit_m_s] * 3 + [SHARE * block.angular_limit_rad_s] * 3)
    steps = [block.linear_step_limit_m_s] * 3 + [block.angular_step_limit_rad_s] * 3
    return _speeds(
        robot, part, ControlMode.BODY_TWIST, robot.base_frame, "", full, steps, block.free_axes
    )


def _speeds(
    robot: RobotManifest,
    part: Part,
    mode: ControlMode,
    frame: str,
    tool: str,
    full: FloatArray,
    steps: list[float],
    columns: tuple[int, ...] = (0, 1, 2, 3, 4, 5),
) -> Drive:
    """A part that is told speeds along the axes of a frame."""
    own = list(columns)
    period_s = robot.tick_period_ns * 1e-9
    far = np.full(len(own), math.inf)
    change = np.minimum(_ramp(full, period_s), 0.5 * np.array(steps))
    return Drive(
        part=part.name,
        mode=mode,
        frame=frame,
        tool=tool,
        names=tuple((XYZ + TURNS)[axis] for axis in own),
        units=tuple("m" if axis < len(XYZ) else "rad" for axis in own),
        columns=columns,
        width=len(XYZ + TURNS),
        full=full[own],
        change=change[own],
        lower=-far,
        upper=far,
        lead=far,
    )


def _ramp(full: FloatArray, period_s: float) -> FloatArray:
    return full / max(1.0, RAMP_S / period_s)
