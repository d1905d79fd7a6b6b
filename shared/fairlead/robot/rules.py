"""Rules of a robot manifest that concern more than one entry.

Every rule returns complete sentences that name the joint, part or mode; the manifest is
refused with all of them at once.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from fairlead.robot.joint import Joint
from fairlead.robot.mode_limits import Finite, SafetyBlock
from fairlead.robot.part import EndEffector, Part, SimulatorNames
from fairlead.robot.safety_profile import ProfileName, SafetyProfile
from fairlead.robot.safety_rules import safety_problems, same_names


def reference_problems(
    *,
    joints: Sequence[Joint],
    passive_joints: Sequence[Joint],
    base_joints: Sequence[str],
    parts: Sequence[Part],
    end_effectors: Sequence[EndEffector],
    home: HomePose | None,
    simulator: SimulatorNames | None,
    safety: Mapping[ProfileName, SafetyProfile],
) -> list[str]:
    """Everything that does not fit together, in the order of the file; [] if all fits."""
    measured = {joint.name: joint for joint in (*joints, *passive_joints)}
    problems = list(_repeated("joint", (joint.name for joint in (*joints, *passive_joints))))
    problems += (
        f"passive joint {joint.name!r}: expected position limits, got a joint of type continuous"
        for joint in passive_joints
        if joint.type == "continuous"
    )
    problems += _repeated("part", (part.name for part in parts))
    problems += _repeated("end effector", (tool.name for tool in end_effectors))
    problems += _part_problems(joints, parts)
    problems += _base_problems(joints, base_joints)
    problems += _tool_problems(joints, parts, end_effectors)
    if home is not None:
        problems += home_problems((*joints, *passive_joints), home)
    if simulator is not None:
        problems += same_names("simulator.joints", measured, {**measured, **simulator.joints})
        for name, sources in simulator.joints.items():
            if not 1 <= len(sources) <= 2:
                problems.append(
                    f"simulator.joints: {name!r} expected one or two simulator joints, "
                    f"got {len(sources)}"
                )
    for profile, block in safety.items():
        problems += (
            f"safety.{profile}: {text}"
            for text in safety_problems(joints, passive_joints, parts, block)
        )
    return problems


def _repeated(what: str, names: Iterable[str]) -> Iterator[str]:
    for name, count in Counter(names).items():
        if count > 1:
            yield f"{what} {name!r} is declared {count} times"


def _part_problems(joints: Sequence[Joint], parts: Sequence[Part]) -> Iterator[str]:
    owners: dict[str, list[str]] = {joint.name: [] for joint in joints}
    for part in parts:
        yield from _repeated(f"part {part.name!r}: joint", part.joints)
        yield from _gripper_problems(joints, part)
        for name in dict.fromkeys(part.joints):
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


def _gripper_problems(joints: Sequence[Joint], part: Part) -> Iterator[str]:
    modes = [mode for mode in ("gripper_binary", "gripper_position") if mode in part.modes]
    bounded = [joint.name for joint in joints if joint.has_bounds and joint.name in part.joints]
    if modes and not len(part.joints) == len(bounded) == 1:
        yield (
            f"part {part.name!r}: {', '.join(modes)}: expected exactly one joint, with position "
            f"limits, got {list(part.joints)}"
        )


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
        modes = part.control_modes
        needing = [one.yaml_name for one in modes if one.is_tool_mode or one.is_gripper_mode]
        if needing and part.end_effector is None:
            yield f"part {part.name!r}: {', '.join(needing)} needs an end_effector"
        elif part.end_effector is not None and part.end_effector not in tools:
            yield (
                f"part {part.name!r}: no end effector {part.end_effector!r} "
                f"(valid: {', '.join(tools) or 'none'})"
            )


class HomePose(SafetyBlock):
    """Where a robot rests, the block ``home`` of robot.yaml.

    positions: of every joint with position limits, commanded or passive [rad or m].
    """

    positions: dict[str, Finite]
    source: str


def home_problems(joints: Sequence[Joint], home: HomePose) -> Iterator[str]:
    """Joints without a place to rest, with one that is none, and names of no such joint."""
    bounded = {joint.name: joint for joint in joints if joint.has_bounds}
    endless = {joint.name for joint in joints} - set(bounded)
    yield from same_names("home.positions", bounded, set(home.positions) - endless)
    for name in sorted(endless & set(home.positions)):
        yield f"home.positions: joint {name!r} has no position limits, so no home: leave it out"
    for name, position in home.positions.items():
        if name in bounded and not bounded[name].lower <= position <= bounded[name].upper:
            lower, upper = bounded[name].lower, bounded[name].upper
            yield (
                f"home: joint {name!r}: expected a position from {lower} to {upper}, got {position}"
            )


CONFIRMED_ONLY = "hardware"
"""The profile that takes no number which nobody confirmed."""


def open_problems(document: object, keys: Mapping[str, str]) -> Iterator[str]:
    """Entries of ``to_confirm`` that lead to nothing, or do not say why.

    Numbers that a person has yet to give or confirm. Each key leads to a number, or to a block of
    them, by names: ``joints.elbow.velocity_rad_s``, ``safety.sim.measured.elbow``. Its value says
    what the number is now and why that may be wrong.
    """
    for key, why in keys.items():
        if not _leads_somewhere(document, key):
            yield f"to_confirm: {key!r} leads to nothing that robot.yaml gives"
        if not why.strip():
            yield f"to_confirm: {key!r}: expected why, in words, got {why!r}"


def _leads_somewhere(document: object, key: str) -> bool:
    """Names may have dots in them, so each that fits is tried."""
    if isinstance(document, Mapping):
        inside = [(str(name), value) for name, value in document.items()]
    elif isinstance(document, list | tuple):
        named = [one for one in document if isinstance(one, Mapping) and "name" in one]
        inside = [(str(one["name"]), one) for one in named]
    else:
        return False
    return any(
        value is not None if key == name else _leads_somewhere(value, key.removeprefix(f"{name}."))
        for name, value in inside
        if key == name or key.startswith(f"{name}.")
    )
