"""Limits that nothing could ever exceed: they look like limits and enforce nothing.

Most are a wrong unit (degrees, millimetres, per second for per period) or a slipped digit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fairlead.robot.joint import Joint
from fairlead.robot.part import Part
from fairlead.robot.safety_profile import MeasuredLimits, PartSafety


def measured_beyond(joint: Joint, limits: MeasuredLimits) -> Iterator[str]:
    """What of a joint's measured limits no measurement could exceed."""
    key = f"measured: joint {joint.name!r}"
    if limits.standstill_per_s >= joint.velocity_limit:
        yield (
            f"{key}: expected standstill_per_s below the joint's velocity limit, "
            f"{joint.velocity_limit:g}, got {limits.standstill_per_s:g}"
        )
    if not joint.has_bounds:
        return
    span = joint.upper - joint.lower
    for name in ("tolerance", "jump_per_tick", "encoder_step", "dead_band_per_tick"):
        value = getattr(limits, name)
        if value is not None and value > span:
            yield f"{key}: expected {name} up to the joint's whole range, {span:g}, got {value:g}"


def told_beyond(joints: Sequence[Joint], part: Part, limits: PartSafety) -> Iterator[str]:
    """What of a part's limits no command and no motion could exceed."""
    mine = {joint.name: joint for joint in joints if joint.name in part.joints}
    order = [mine[name] for name in part.joints if name in mine]
    spans = [joint.upper - joint.lower if joint.has_bounds else None for joint in order]
    speeds = [2.0 * joint.velocity_limit for joint in order]
    for mode, most in (
        ("joint_position", spans),
        ("dex_hand_joint", spans),
        ("joint_velocity", speeds),
    ):
        for name in ("step_limits", "tracking_limits"):
            told = getattr(getattr(limits, mode), name, None) or ()
            for joint, value, limit in zip(order, told, most, strict=False):
                if limit is not None and value > limit:
                    yield (
                        f"part {part.name!r}: {mode}: expected {name} of {joint.name!r} up to "
                        f"{limit:g}, from one end to the other, got {value:g}"
                    )
    opening = limits.gripper_position
    if opening is not None:
        stroke = opening.upper - opening.lower
        for name in (f"step_limit_{opening.unit}", f"slip_limit_{opening.unit}"):
            value = getattr(opening, name)
            if value is not None and value > stroke:
                yield (
                    f"part {part.name!r}: gripper_position: expected {name} up to the whole "
                    f"stroke, {stroke:g}, got {value:g}"
                )
