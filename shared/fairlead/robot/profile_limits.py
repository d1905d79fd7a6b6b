"""The motion limits of a commanded joint in a profile: its own, or the profile's tighter ones."""

from __future__ import annotations

from fairlead.robot.joint import Joint
from fairlead.robot.safety_profile import SafetyProfile


def profile_limits(joint: Joint, safety: SafetyProfile) -> tuple[float, float, float, str]:
    """Velocity, acceleration and effort limit of a commanded joint in a profile, and the source."""
    own = (joint.velocity_limit, joint.acceleration_limit, joint.effort_limit)
    tighter = safety.tighter_joints.get(joint.name)
    if tighter is None:
        return (*own, joint.source)
    given = (tighter.velocity_per_s, tighter.acceleration_per_s2, tighter.effort)
    velocity, acceleration, effort = (
        mine if less is None else less for mine, less in zip(own, given, strict=True)
    )
    nothing_own = not joint.has_bounds and None not in given
    source = tighter.source if nothing_own else f"{tighter.source}; {joint.source}"
    return velocity, acceleration, effort, source


def outside_limits(joint: Joint, safety: SafetyProfile, position: float) -> str:
    """How far off a measured position is [rad or m], "" within the limits and their tolerance."""
    beyond = safety.measured[joint.name].tolerance or 0.0
    if not joint.has_bounds or joint.lower - beyond <= position <= joint.upper + beyond:
        return ""
    return f"{joint.name}: {position:.3g} {joint.unit}, declared {joint.lower:g} to {joint.upper:g}"
