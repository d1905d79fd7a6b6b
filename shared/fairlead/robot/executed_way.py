"""What interpolation adds to a profile's limits, for the gate.

The gate takes each joint straight from row to row, there at the row's end. The executed way is late
and beside that one, both by bounds that the gate's file has in its limits: what the gate keeps
clear of its own way, the limits of robot.yaml keep clear of the way that is executed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TypeVar

from fairlead.errors import ConfigError, expected
from fairlead.robot.capsules import CapsuleFile
from fairlead.robot.description import DescriptionTree, Link
from fairlead.robot.interpolation import ENDS_PERIODS, LATE_PERIODS
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.mode_limits import SafetyBlock
from fairlead.robot.safety_profile import SafetyProfile, profile_limits
from fairlead.robot.tool_reach import Reach

Block = TypeVar("Block", bound=SafetyBlock)


def smoothed_changes(robot: RobotManifest, profile: str) -> dict[str, float]:
    """By commanded joint, up to which change of step from row to row the way is smooth.

    That of the joint's acceleration limit in the profile over a period [rad or m]; of a larger
    change the rest stays a leap of velocity, as it is without interpolation. The way leaves the
    straight one by a sixth of it at most.
    """
    safety, period_s = robot.profile(profile), robot.tick_period_ns * 1e-9
    return {one.name: profile_limits(one, safety)[1] * period_s**2 for one in robot.joints}


def limits_for_the_gate(
    robot: RobotManifest, profile: str, tree: DescriptionTree, shape: CapsuleFile
) -> SafetyProfile:
    """A profile with room for the robot's interpolation; as declared where that is linear.

    Raises:
        ConfigError: for a robot with a mobile base, whose footprint has no such room.
    """
    safety = robot.profile(profile)
    if robot.interpolation == "linear":
        return safety
    if safety.base is not None:
        who = f"robot {robot.id}: interpolation of a mobile base"
        raise ConfigError(expected(who, "linear", robot.interpolation))
    period_s = robot.tick_period_ns * 1e-9
    late, ends = LATE_PERIODS[robot.interpolation], ENDS_PERIODS[robot.interpolation]
    beside = {name: change / 6.0 for name, change in smoothed_changes(robot, profile).items()}
    pairs, volumes = _beside_pairs(robot, tree, shape, beside), _beside(robot, tree, shape, beside)
    return safety.model_copy(
        update={
            "measured": {
                name: one
                if one.stop_lag_s is None
                else one.model_copy(update={"stop_lag_s": _up(one.stop_lag_s + late * period_s)})
                for name, one in safety.measured.items()
            },
            "parts": {
                name: part.model_copy(
                    update={mode: _tracked(getattr(part, mode), late) for mode in part.names}
                )
                for name, part in safety.parts.items()
            },
            "self_collision": safety.self_collision.model_copy(
                update={"clearance_m": _up(safety.self_collision.clearance_m + pairs)}
            ),
            "workspace": safety.workspace.model_copy(
                update={"margin_m": _up(safety.workspace.margin_m + volumes)}
            ),
            "protocol": safety.protocol.model_copy(
                update={
                    "stop_ramp_ms": safety.protocol.stop_ramp_ms
                    + math.ceil(ends * robot.control_period_ms)
                }
            ),
        }
    )


def _up(value: float) -> float:
    """Readable, and no less."""
    return math.ceil(value * 1e6) / 1e6


def _tracked(mode: Block, late: float) -> Block:
    """For each period that a motion is late, it is off by what a row changes at most.

    And by a sixth of that: where only one of two changes is smoothed.
    """
    more, rows = dict[str, float | tuple[float, ...]](), late + 1 / 6
    for name in type(mode).model_fields:
        step = name.replace("tracking_limits", "step_limits").replace("tracking_", "step_limit_")
        if step == name:
            continue
        now, change = getattr(mode, name), getattr(mode, step)
        if isinstance(now, tuple):
            more[name] = tuple(_up(a + rows * b) for a, b in zip(now, change, strict=True))
        else:
            more[name] = _up(now + rows * change)
    return mode.model_copy(update=more)


def _beside_pairs(
    robot: RobotManifest, tree: DescriptionTree, shape: CapsuleFile, beside: Mapping[str, float]
) -> float:
    """By how much two capsules that are kept apart come nearer than on the straight way [m]."""
    reach, nearest = Reach(robot, tree), 0.0
    for pair in shape.checked_pairs:
        chains = [reach.chain(shape.capsules[index].link) for index in pair]
        shared = sum(a == b for a, b in zip(*chains, strict=False))
        moved = [
            _moved(reach, chain[shared:], _extent(shape, index), beside)
            for chain, index in zip(chains, pair, strict=True)
        ]
        nearest = max(nearest, sum(moved))
    return nearest


def _beside(
    robot: RobotManifest, tree: DescriptionTree, shape: CapsuleFile, beside: Mapping[str, float]
) -> float:
    """By how much a tool or a capsule is beside its straight way at most [m]."""
    reach = Reach(robot, tree)
    ends = [(one.link, _extent(shape, index)) for index, one in enumerate(shape.capsules)]
    ends += [(tool.tool_frame, 0.0) for tool in robot.end_effectors]
    return max(_moved(reach, reach.chain(frame), extent, beside) for frame, extent in ends)


def _extent(shape: CapsuleFile, index: int) -> float:
    capsule = shape.capsules[index]
    return max(math.hypot(*capsule.a_m), math.hypot(*capsule.b_m))


def _moved(
    reach: Reach, chain: Sequence[Link], extent: float, beside: Mapping[str, float]
) -> float:
    """How far a point ``extent`` from a chain's end moves where each joint is so far beside.

    A joint that turns carries it by at most the way from joint to joint and on to the point.
    """
    far, moved = extent, 0.0
    for link in reversed(chain):
        turn = beside.get(link.joint or "", 0.0)
        moved += turn if link.kind == "prismatic" else turn * far
        far += reach.span(link)
    return moved
