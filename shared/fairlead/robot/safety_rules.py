"""Rules of a safety profile: what it must say about the joints and parts of its robot."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from fairlead.modes import GATED_MODES
from fairlead.robot.joint import Joint
from fairlead.robot.part import Part
from fairlead.robot.safety_profile import MeasuredLimits, PartSafety, SafetyProfile

_OF_COMMANDED = ("contact_limit", "encoder_step", "dead_band_per_tick", "stop_lag_s")
_TOOL_MODES = frozenset({"cartesian_pose", "cartesian_delta", "cartesian_twist"})
_PER_JOINT = ("joint_position", "joint_velocity", "dex_hand_joint")


def safety_problems(
    joints: Sequence[Joint],
    passive_joints: Sequence[Joint],
    parts: Sequence[Part],
    block: SafetyProfile,
) -> Iterator[str]:
    """Everything in one profile that does not fit its robot, in the order of the file."""
    measured = {joint.name: joint for joint in (*joints, *passive_joints)}
    yield from same_names("measured", measured, block.measured)
    for name, limits in block.measured.items():
        if name in measured:
            commanded = measured[name] in joints
            yield from _measured_problems(measured[name], limits, commanded=commanded)
            yield from measured_beyond(measured[name], limits)
    yield from _tighter_problems(joints, block)
    yield from same_names("parts", [part.name for part in parts], block.parts)
    for part in parts:
        if part.name in block.parts:
            yield from _part_problems(joints, part, block.parts[part.name])
            yield from told_beyond(joints, part, block.parts[part.name])
    yield from _gain_problems(block)
    yield from _surroundings_problems(joints, parts, block)
    timeout_us = block.protocol.state_timeout_ms * 1000
    if block.protocol.step_deadline_us >= timeout_us:
        yield (
            f"protocol: step_deadline_us: expected less than state_timeout_ms, {timeout_us} us,"
            f" got {block.protocol.step_deadline_us}"
        )


def same_names(what: str, wanted: Iterable[str], got: Iterable[str]) -> Iterator[str]:
    """What is missing in a list of names, and what is there without being asked for."""
    wanted, got = list(wanted), list(got)
    missing = [name for name in wanted if name not in got]
    extra = [name for name in got if name not in wanted]
    if missing:
        yield f"{what}: missing {', '.join(missing)}"
    if extra:
        yield f"{what}: unknown {', '.join(extra)} (valid: {', '.join(wanted)})"


def _measured_problems(joint: Joint, limits: MeasuredLimits, *, commanded: bool) -> Iterator[str]:
    key = f"measured: joint {joint.name!r}"
    if joint.has_bounds != (limits.tolerance is not None):
        state = "missing" if joint.has_bounds else "given for a joint without position limits"
        yield f"{key}: tolerance is {state}"
    for name in _OF_COMMANDED:
        if commanded != (getattr(limits, name) is not None):
            state = "missing" if commanded else "given for a joint that is not commanded"
            yield f"{key}: {name} is {state}"


def _tighter_problems(joints: Sequence[Joint], block: SafetyProfile) -> Iterator[str]:
    commanded = {joint.name: joint for joint in joints}
    for name, limits in block.tighter_joints.items():
        joint = commanded.get(name)
        if joint is None:
            yield f"tighter_joints: {name!r} is no commanded joint (valid: {', '.join(commanded)})"
            continue
        own = {
            "velocity_per_s": joint.velocity_limit,
            "acceleration_per_s2": joint.acceleration_limit,
            "effort": joint.effort_limit,
        }
        for key, most in own.items():
            value = getattr(limits, key)
            if value is not None and value > most:
                yield (
                    f"tighter_joints: joint {name!r}: expected {key} of at most its own, {most}, "
                    f"got {value}"
                )


def _part_problems(joints: Sequence[Joint], part: Part, limits: PartSafety) -> Iterator[str]:
    key = f"part {part.name!r}"
    unchecked = [mode.yaml_name for mode in part.control_modes if mode not in GATED_MODES]
    if unchecked:
        yield f"{key}: the gate has no checker for {', '.join(unchecked)}"
    if "joint_torque" in unchecked:
        yield (
            f"{key}: joint_torque needs a model of the robot's dynamics that bounds where a torque "
            "leads before the gate can take it back; without one use joint_velocity or a pose"
        )
    yield from same_names(
        f"{key} modes", [mode for mode in part.modes if mode not in unchecked], limits.names
    )
    for mode in _PER_JOINT:
        for name in ("step_limits", "tracking_limits"):
            numbers = getattr(getattr(limits, mode), name, None)
            if numbers is not None and len(numbers) != len(part.joints):
                yield (
                    f"{key}: {name}: expected one per joint, {len(part.joints)}, got {len(numbers)}"
                )
    if "composite_mode" in limits.names and len(limits.names) > 1:
        others = [name for name in limits.names if name != "composite_mode"]
        yield f"{key} modes: expected composite_mode alone, got {', '.join(others)} beside it"
    moves_tool = not _TOOL_MODES.isdisjoint(limits.names)
    if moves_tool != (limits.singularity_limit is not None):
        state = "missing" if moves_tool else "given without a cartesian mode"
        yield f"{key}: singularity_limit is {state}"
    yield from _opening_problems(joints, part, limits)
    yield from _transition_problems(key, limits)


def _gain_problems(block: SafetyProfile) -> Iterator[str]:
    """With a composite switch up the next row does what one leaves: less than nothing is none."""
    if all(limits.composite_mode is None for limits in block.parts.values()):
        return
    for part, limits in block.parts.items():
        for mode in ("cartesian_delta", "cartesian_twist"):
            told = getattr(limits, mode)
            if told is not None and told.gain[1] > 1.0:
                yield (
                    f"part {part!r}: {mode}.gain: expected at most 1, as the robot has a composite "
                    f"switch, got {told.gain[1]}"
                )


def _opening_problems(joints: Sequence[Joint], part: Part, limits: PartSafety) -> Iterator[str]:
    mine = [joint for joint in joints if joint.name in part.joints and joint.has_bounds]
    told = limits.gripper_position
    if told is None or len(mine) != 1:
        return
    key, unit = f"part {part.name!r}: gripper_position", mine[0].unit
    if told.unit != unit:
        yield (
            f"{key}: expected limits in {unit}, as {mine[0].name!r} is {mine[0].type}, got "
            f"lower_{told.unit}"
        )
    elif told.lower < mine[0].lower or told.upper > mine[0].upper:
        yield (
            f"{key}: expected lower_{unit} and upper_{unit} inside the limits of "
            f"{mine[0].name!r}, {mine[0].lower} and {mine[0].upper}, got {told.lower} and "
            f"{told.upper}"
        )


def _transition_problems(key: str, limits: PartSafety) -> Iterator[str]:
    if limits.transitions == "any":
        return
    for pair, count in Counter(limits.transitions).items():
        if not set(pair) <= set(limits.names) or pair[0] == pair[1]:
            yield (
                f"{key}: transitions: expected two different modes of the part, got "
                f"{list(pair)} (valid: {', '.join(limits.names)})"
            )
        elif count > 1:
            yield f"{key}: transitions: {list(pair)} is there {count} times"


def _surroundings_problems(
    joints: Sequence[Joint], parts: Sequence[Part], block: SafetyProfile
) -> Iterator[str]:
    kinds = [volume.kind for volume in block.workspace.volumes]
    if "keep_in" not in kinds and any(part.end_effector is not None for part in parts):
        yield f"workspace.volumes: expected one of kind keep_in for the robot's tools, got {kinds}"
    zoned = [joint.name for joint in joints if joint.bounded_by == "zones"]
    if zoned and block.base is None:
        yield f"base: missing; zones bound {', '.join(zoned)}"
    base = [joint.name for joint in joints if joint.role == "base"]
    if block.base is not None and len(base) != 3:
        yield f"base: expected three joints of role base, x, y and yaw, got {base}"


# Limits that nothing could ever exceed look like limits and enforce nothing. Most are a wrong unit
# (degrees, millimetres, per second for per period) or a slipped digit.


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
