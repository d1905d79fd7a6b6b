"""Rules of a robot manifest that concern more than one entry.

Every rule returns complete sentences that name the joint, part or mode; the manifest is
refused with all of them at once.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from fairlead.modes import GATED_MODES, ControlMode
from fairlead.robot.joint import Joint
from fairlead.robot.part import EndEffector, Part, SimulatorNames
from fairlead.robot.safety_profile import ProfileName, SafetyProfile


def reference_problems(
    *,
    joints: Sequence[Joint],
    passive_joints: Sequence[Joint],
    base_joints: Sequence[str],
    parts: Sequence[Part],
    end_effectors: Sequence[EndEffector],
    simulator: SimulatorNames | None,
    safety: Mapping[ProfileName, SafetyProfile],
) -> list[str]:
    """Everything that does not fit together, in the order of the file; [] if all fits."""
    measured = {joint.name: joint for joint in (*joints, *passive_joints)}
    problems = list(_repeated("joint", (joint.name for joint in (*joints, *passive_joints))))
    problems += _repeated("part", (part.name for part in parts))
    problems += _repeated("end effector", (tool.name for tool in end_effectors))
    problems += _part_problems(joints, parts)
    problems += _base_problems(joints, base_joints)
    problems += _tool_problems(joints, parts, end_effectors)
    if simulator is not None:
        problems += _same_names("simulator.joints", measured, simulator.joints)
        for name, sources in simulator.joints.items():
            if not 1 <= len(sources) <= 2:
                problems.append(
                    f"simulator.joints: {name!r} expected one or two simulator joints, "
                    f"got {len(sources)}"
                )
    for profile, block in safety.items():
        problems += (
            f"safety.{profile}: {text}" for text in _safety_problems(measured, parts, block)
        )
    return problems


def _repeated(what: str, names: Iterable[str]) -> Iterator[str]:
    for name, count in Counter(names).items():
        if count > 1:
            yield f"{what} {name!r} is declared {count} times"


def _part_problems(joints: Sequence[Joint], parts: Sequence[Part]) -> Iterator[str]:
    owners: dict[str, list[str]] = {joint.name: [] for joint in joints}
    for part in parts:
        for name in part.joints:
            if name not in owners:
                yield (
                    f"part {part.name!r}: joint {name!r} is not a commanded joint "
                    f"(valid: {', '.join(owners)})"
                )
            else:
                owners[name].append(part.name)
    for name, owning in owners.items():
        if len(owning) != 1:
            yield f"joint {name!r}: expected exactly one part, got {owning}"


def _base_problems(joints: Sequence[Joint], base_joints: Sequence[str]) -> Iterator[str]:
    base = [joint.name for joint in joints if joint.role == "base"]
    if list(base_joints) != base:
        yield (
            f"base_joints: expected the joints of role base in order, {base}, "
            f"got {list(base_joints)}"
        )


def _tool_problems(
    joints: Sequence[Joint], parts: Sequence[Part], end_effectors: Sequence[EndEffector]
) -> Iterator[str]:
    tools = {tool.name: tool for tool in end_effectors}
    names = [joint.name for joint in joints]
    # Each joint of a hand is commanded by name: none of them alone opens it.
    hands = {part.end_effector for part in parts if "dex_hand_joint" in part.modes}
    for tool in end_effectors:
        if tool.name in hands and (tool.gripper_joint is not None or not tool.actuated):
            yield f"end effector {tool.name!r}: a hand is actuated and has no gripper_joint"
        elif tool.name not in hands and tool.actuated != (tool.gripper_joint is not None):
            yield f"end effector {tool.name!r}: actuated and gripper_joint go together"
        elif tool.gripper_joint is not None and tool.gripper_joint not in names:
            yield (
                f"end effector {tool.name!r}: gripper_joint {tool.gripper_joint!r} is not a "
                f"commanded joint (valid: {', '.join(names)})"
            )
    for part in parts:
        needing = [mode.yaml_name for mode in part.control_modes if mode in _TOOL_MODES]
        if needing and part.end_effector is None:
            yield f"part {part.name!r}: {', '.join(needing)} needs an end_effector"
        elif part.end_effector is not None and part.end_effector not in tools:
            yield (
                f"part {part.name!r}: no end effector {part.end_effector!r} "
                f"(valid: {', '.join(tools) or 'none'})"
            )


_TOOL_MODES = frozenset(
    {
        ControlMode.CARTESIAN_POSE,
        ControlMode.CARTESIAN_DELTA,
        ControlMode.CARTESIAN_TWIST,
        ControlMode.GRIPPER_BINARY,
        ControlMode.GRIPPER_POSITION,
    }
)


def _safety_problems(
    measured: Mapping[str, Joint], parts: Sequence[Part], block: SafetyProfile
) -> Iterator[str]:
    yield from _same_names("measured", measured, block.measured)
    for name, limits in block.measured.items():
        joint = measured.get(name)
        if joint is not None and joint.has_bounds != (limits.tolerance is not None):
            state = "missing" if joint.has_bounds else "given for a joint without position limits"
            yield f"measured: joint {name!r}: tolerance is {state}"
    yield from _same_names("parts", [part.name for part in parts], block.parts)
    for part in parts:
        modes = block.parts.get(part.name)
        if modes is None:
            continue
        unchecked = [mode.yaml_name for mode in part.control_modes if mode not in GATED_MODES]
        if unchecked:
            yield f"part {part.name!r}: the gate has no checker for {', '.join(unchecked)}"
        yield from _same_names(
            f"part {part.name!r} modes", [m for m in part.modes if m not in unchecked], modes.names
        )
        for mode in (
            modes.joint_position,
            modes.joint_velocity,
            modes.joint_torque,
            modes.dex_hand_joint,
        ):
            if mode is not None and len(mode.step_limits) != len(part.joints):
                yield (
                    f"part {part.name!r}: step_limits: expected one per joint, "
                    f"{len(part.joints)}, got {len(mode.step_limits)}"
                )


def _same_names(what: str, wanted: Iterable[str], got: Iterable[str]) -> Iterator[str]:
    wanted, got = list(wanted), list(got)
    missing = [name for name in wanted if name not in got]
    extra = [name for name in got if name not in wanted]
    if missing:
        yield f"{what}: missing {', '.join(missing)}"
    if extra:
        yield f"{what}: unknown {', '.join(extra)} (valid: {', '.join(wanted)})"
