"""Limits that were never meant, asked against what the robot can do.

A limit above all that its joints could do at once enforces nothing; most are a wrong unit or a
slipped digit. Each row of the table has the number, the most that it can mean, and where that
comes from. What needs no description is asked when robot.yaml is read
(`fairlead.robot.safety_rules`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from fairlead.errors import ConfigError
from fairlead.robot.description import DescriptionTree
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.mode_limits import (
    BodyTwistMode,
    CartesianDeltaMode,
    CartesianPoseMode,
    CartesianTwistMode,
)
from fairlead.robot.part import Part
from fairlead.robot.safety_profile import PartSafety, SafetyProfile, profile_limits
from fairlead.robot.tool_reach import Reach, ToolSpeed

_PERIODS = 20
"""A measured jump is a sensor's fault or a blow: not more than this many periods at full speed."""
_FAR = 2.0
"""Of the reach: a side of a box beyond it was meant in another unit."""
_SLACK = 1.0 + 1e-9
_MOST_BASE_M, _MOST_ODOM_M = 10.0, 1000.0

Row = tuple[str, float, float, str]
"""Key, number, the most that it can mean, and what that is."""


@dataclass(frozen=True)
class _Can:
    """What a robot can do in a profile. speeds: of each commanded joint [rad/s or m/s]."""

    robot: RobotManifest
    safety: SafetyProfile
    reach: Reach
    speeds: Mapping[str, float]

    @property
    def period_s(self) -> float:
        return self.robot.tick_period_ns * 1e-9

    @property
    def ramp_s(self) -> float:
        return self.safety.protocol.stop_ramp_ms * 1e-3


def check_possible(robot: RobotManifest, profile: str, tree: DescriptionTree) -> None:
    """Whether every limit of a profile could ever be exceeded.

    Raises:
        ConfigError: naming each that could not, with its value, the most that it can mean, and
            where that comes from.
    """
    safety = robot.profile(profile)
    speeds = {joint.name: profile_limits(joint, safety)[0] for joint in robot.joints}
    can = _Can(robot, safety, Reach(robot, tree), speeds)
    problems = [
        f"robot {robot.id}: safety.{profile}: {key}: expected up to {most:.4g}, {why}, "
        f"got {value:g}"
        for key, value, most, why in _rows(can)
        if not value <= most * _SLACK
    ]
    problems += [f"robot {robot.id}: safety.{profile}: {text}" for text in _idle_volumes(can)]
    if problems:
        raise ConfigError("\n".join(problems))


def _rows(can: _Can) -> Iterator[Row]:
    yield from _joint_rows(can)
    yield from _measured_rows(can)
    for part in can.robot.parts:
        yield from _part_rows(can, part, can.safety.parts[part.name])
    yield from _surrounding_rows(can)


def _joint_rows(can: _Can) -> Iterator[Row]:
    for joint in can.robot.joints:
        key, speed = f"joint {joint.name!r}", can.speeds[joint.name]
        if joint.has_bounds:
            span = (joint.upper - joint.lower) / can.period_s
            yield f"{key}: velocity", speed, span, "its whole range in one period"
        if joint.unit == "rad":
            half = math.pi / can.period_s
            yield f"{key}: velocity", speed, half, "half a turn in one period"
        if not can.robot.owner(joint.name).only_grips:
            acceleration = profile_limits(joint, can.safety)[1]
            most = 2.0 * speed / can.period_s
            yield f"{key}: acceleration", acceleration, most, "a full reversal in one period"


def _measured_rows(can: _Can) -> Iterator[Row]:
    for name, told in can.safety.measured.items():
        joint, key = can.robot.joint(name), f"measured.{name}"
        way = can.speeds.get(name, joint.velocity_limit) * can.period_s
        jump = f"the way of {_PERIODS} periods at full speed"
        yield f"{key}.jump_per_tick", told.jump_per_tick, _PERIODS * way, jump
        for field in ("encoder_step", "dead_band_per_tick"):
            value = getattr(told, field)
            if value is not None:
                yield f"{key}.{field}", value, way, "the way of one period at full speed"
        if told.stop_lag_s is not None:
            yield f"{key}.stop_lag_s", told.stop_lag_s, can.ramp_s, "protocol.stop_ramp_ms"
        if told.contact_limit is not None:
            most = 2.0 * joint.effort_limit
            yield f"{key}.contact_limit", told.contact_limit, most, "twice the joint's effort limit"


def _part_rows(can: _Can, part: Part, told: PartSafety) -> Iterator[Row]:
    key = f"parts.{part.name}"
    if part.end_effector is not None:
        frame = can.robot.end_effector(part.end_effector).tool_frame
        tool = can.reach.tool_speed(frame, part.joints, can.speeds)
        far_m = 2.0 * can.reach.of(frame)
        if told.cartesian_delta is not None:
            yield from _delta_rows(can, f"{key}.cartesian_delta", told.cartesian_delta, tool, far_m)
        if told.cartesian_twist is not None:
            yield from _twist_rows(
                f"{key}.cartesian_twist", told.cartesian_twist, tool, _ALL_JOINTS
            )
        if told.cartesian_pose is not None:
            yield from _pose_rows(f"{key}.cartesian_pose", told.cartesian_pose, far_m)
    if told.body_twist is not None:
        own = {name: can.speeds[name] for name in part.joints}
        slides = [own[name] for name in own if can.robot.joint(name).unit == "m"]
        turns = [own[name] for name in own if can.robot.joint(name).unit == "rad"]
        base = ToolSpeed(math.hypot(*slides), sum(turns))
        yield from _twist_rows(f"{key}.body_twist", told.body_twist, base, "all the base's joints")
    if told.composite_mode is not None:
        step = told.composite_mode.step_limit
        yield f"{key}.composite_mode.step_limit", step, 2.0, "from -1 to 1"


_ALL_JOINTS = "all the part's joints at full speed, in half of all postures,"


def _delta_rows(
    can: _Can, key: str, told: CartesianDeltaMode, tool: ToolSpeed, far_m: float
) -> Iterator[Row]:
    share = max(told.gain)
    for kind, unit, speed, farthest, why in (
        ("linear", "m", tool.linear_m_s, far_m, "from one end of the tool's reach to the other"),
        ("angular", "rad", tool.angular_rad_s, math.pi, "half a turn"),
    ):
        limit = getattr(told, f"{kind}_limit_{unit}")
        way = speed * can.period_s
        does = f"what {_ALL_JOINTS} do in one period, by the largest share in gain"
        yield f"{key}.{kind}_limit_{unit}", limit, way / share, does
        yield f"{key}.{kind}_limit_{unit}", limit, farthest, why
        step = getattr(told, f"{kind}_step_limit_{unit}")
        yield f"{key}.{kind}_step_limit_{unit}", step, 2.0 * limit, "a full reversal"
        tracking = getattr(told, f"{kind}_tracking_{unit}")
        most = way + share * limit
        yield f"{key}.{kind}_tracking_{unit}", tracking, most, f"{_ALL_JOINTS} against a full row"


def _twist_rows(
    key: str, told: CartesianTwistMode | BodyTwistMode, can: ToolSpeed, who: str
) -> Iterator[Row]:
    share = max(told.gain)
    for kind, unit, speed in (
        ("linear", "m_s", can.linear_m_s),
        ("angular", "rad_s", can.angular_rad_s),
    ):
        limit = getattr(told, f"{kind}_limit_{unit}")
        does = f"what {who} make, by the largest share in gain"
        yield f"{key}.{kind}_limit_{unit}", limit, speed / share, does
        step = getattr(told, f"{kind}_step_limit_{unit}")
        yield f"{key}.{kind}_step_limit_{unit}", step, 2.0 * limit, "a full reversal"
        tracking = getattr(told, f"{kind}_tracking_{unit}")
        most = speed + share * limit
        yield f"{key}.{kind}_tracking_{unit}", tracking, most, f"{who} against a full row"


def _pose_rows(key: str, told: CartesianPoseMode, far_m: float) -> Iterator[Row]:
    reach = "from one end of the tool's reach to the other"
    for name in ("lower_m", "upper_m"):
        for axis, value in zip("xyz", getattr(told, name), strict=True):
            yield f"{key}.{name} {axis}", abs(value), far_m, reach
    for name in ("linear_step_limit_m", "linear_tracking_m"):
        yield f"{key}.{name}", getattr(told, name), far_m, reach
    for name in ("angular_step_limit_rad", "angular_tracking_rad"):
        yield f"{key}.{name}", getattr(told, name), math.pi, "half a turn"


def _surrounding_rows(can: _Can) -> Iterator[Row]:
    longest = "the longest link: more, and the robot is never clear of itself"
    clearance = can.safety.self_collision.clearance_m
    yield "self_collision.clearance_m", clearance, can.reach.longest_link_m, longest
    most = _FAR * can.reach.farthest_m
    for volume in can.safety.workspace.volumes:
        for name in ("lower_m", "upper_m"):
            for axis, value in zip("xyz", getattr(volume, name), strict=True):
                key = f"workspace.volumes.{volume.name}.{name} {axis}"
                yield key, abs(value), most, "twice the robot's reach"
    base = can.safety.base
    if base is None:
        return
    yield "base.reaction_s", base.reaction_s, can.ramp_s, "protocol.stop_ramp_ms"
    for key, corners, far, what in (
        ("base.footprint_m", base.footprint_m, _MOST_BASE_M, "a base"),
        ("base.yaw_axis_m", (base.yaw_axis_m,), _MOST_BASE_M, "a base"),
        *((f"base.zones.{one.name}", one.corners_m, _MOST_ODOM_M, "a site") for one in base.zones),
    ):
        farthest = max(abs(number) for corner in corners for number in corner)
        yield key, farthest, far, f"{what} in metres"


def _idle_volumes(can: _Can) -> Iterator[str]:
    """Volumes that keep nothing in or out, for nothing gets to any of their sides."""
    tools = [can.reach.of(tool.tool_frame) for tool in can.robot.end_effectors]
    for volume in can.safety.workspace.volumes:
        sides = [*(-value for value in volume.lower_m), *volume.upper_m]
        key = f"workspace.volumes.{volume.name}"
        if volume.kind == "keep_in" and tools and min(sides) > max(tools):
            yield f"{key}: keeps nothing in, no tool gets farther than {max(tools):.4g} m"
        gap = [
            max(low, -high, 0.0) for low, high in zip(volume.lower_m, volume.upper_m, strict=True)
        ]
        if volume.kind == "keep_out" and math.hypot(*gap) > _FAR * can.reach.farthest_m:
            far = can.reach.farthest_m
            yield f"{key}: keeps nothing out, no link gets farther than {far:.4g} m"
