"""Routes: a skill's slots resolved on one robot, part by part.

A slot names end effectors and joints; a route names the part and the columns on the
wire. Slots of the same part and mode become one route; two modes for one part in one
tick are refused.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from fairlead.errors import ConfigError
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.slots import Slot


class SlotFit(NamedTuple):
    """What a slot has done to the policy's numbers before they are scaled.

    slot: its name. sources: indices into the policy's vector. Of clip and threshold one is None.
    """

    slot: str
    sources: tuple[int, ...]
    clip: tuple[float, float] | None
    threshold: float | None


@dataclass(frozen=True)
class Route:
    """Where some dimensions of the action vector go.

    Attributes:
        part: index of the part in the robot's order.
        part_name: its name.
        mode: what the numbers mean.
        frame_id: frame of a cartesian mode or twist, else "".
        width: numbers per row on the wire.
        sources: indices into the policy's vector ...
        columns: ... and the wire column each becomes.
        scale, offset: SI value = scale * output + offset, per source.
        in_units: per source, whether its output is in a unit (no scale of the slot's own).
        active: joint modes only, the commanded joints, ascending.
        threshold: a binary gripper's, in its SI values; None sends them as they are.
        fits: of the slots that clip their numbers, or decide them by a threshold.
    """

    part: int
    part_name: str
    mode: ControlMode
    frame_id: str
    width: int
    sources: tuple[int, ...]
    columns: tuple[int, ...]
    scale: tuple[float, ...]
    offset: tuple[float, ...]
    in_units: tuple[bool, ...]
    active: tuple[int, ...]
    threshold: float | None = None
    fits: tuple[SlotFit, ...] = ()

    @property
    def leaves_axes_free(self) -> bool:
        """Whether a tool's delta names some of its axes only."""
        return self.mode is ControlMode.CARTESIAN_DELTA and len(self.columns) < self.width


def resolve_routes(contract: ActionContract, robot: RobotManifest) -> tuple[Route, ...]:
    """The routes of every slot that is not discarded, in part order.

    Raises:
        ConfigError: with every slot that this robot cannot take, and why.
    """
    routes, problems = plan_routes(contract, robot)
    if problems:
        raise ConfigError("; ".join(problems))
    return routes


def plan_routes(
    contract: ActionContract, robot: RobotManifest
) -> tuple[tuple[Route, ...], list[str]]:
    """As `resolve_routes`, with the problems returned instead of raised."""
    by_part: dict[int, Route] = {}
    problems = _joint_space_problems(contract, robot)
    for slot in contract.routed:
        found = _slot_problems(slot, robot) or _place(slot, robot, by_part)
        problems += [f"{slot.name}: {problem}" for problem in found]
    return tuple(by_part[part] for part in sorted(by_part)), problems


def _joint_space_problems(contract: ActionContract, robot: RobotManifest) -> list[str]:
    """What naming joints instead of slots adds to what can be wrong."""
    names = contract.joint_names
    if names is None:
        return []
    if contract.dim <= robot.n_dof:
        return []
    return [
        f"action_contract: expected at most the {robot.n_dof} joints of robot {robot.id}, "
        f"got dim {contract.dim}"
    ]


def _slot_problems(slot: Slot, robot: RobotManifest) -> list[str]:
    if slot.ee is not None:
        tools = {tool.name: tool for tool in robot.end_effectors}
        if slot.ee not in tools:
            return [_unknown("end effector", slot.ee, robot, tools)]
        opens = slot.mode is not None and slot.mode.is_gripper_mode
        if opens and not tools[slot.ee].actuated:
            return [f"end effector {slot.ee} of robot {robot.id} has actuated: false"]
    names = slot.joint_names or ()
    sliding = [joint.name for joint in robot.joints if joint.type == "prismatic"]
    return [
        *(
            _unknown("joint", name, robot, robot.joint_names)
            for name in names
            if name not in robot.joint_names
        ),
        *(
            f"unit: {slot.unit} does not fit joint {name}, which is prismatic (a slot of its own, "
            "without unit, is in m)"
            for name in names
            if slot.unit and name in sliding
        ),
    ]


def _unknown(what: str, name: str, robot: RobotManifest, valid: Iterable[str]) -> str:
    return f"robot {robot.id} has no {what} {name!r} (valid: {', '.join(valid)})"


def _place(slot: Slot, robot: RobotManifest, by_part: dict[int, Route]) -> list[str]:
    parts = [part for part in robot.parts if _takes(part, slot)]
    if len(parts) != 1:
        names = ", ".join(part.name for part in parts) or "none"
        return [
            f"expected exactly one part of robot {robot.id} to take it, got {names} "
            f"({_describe_modes(_addressed(slot, robot) or robot.parts)})"
        ]
    route = _route(slot, robot, parts[0])
    known = by_part.get(route.part)
    if known is not None and (known.mode, known.frame_id) != (route.mode, route.frame_id):
        return [f"part {route.part_name} is already commanded in {known.mode.yaml_name}"]
    by_part[route.part] = route if known is None else _merged(known, route)
    return []


def _addressed(slot: Slot, robot: RobotManifest) -> list[Part]:
    """The parts that a slot's joints or end effector belong to, whatever modes they take."""
    if slot.joint_names is not None:
        return [part for part in robot.parts if set(slot.joint_names) & set(part.joints)]
    return [part for part in robot.parts if slot.ee and part.end_effector == slot.ee]


def _describe_modes(parts: Iterable[Part]) -> str:
    return "; ".join(f"{part.name} takes {', '.join(part.modes)}" for part in parts)


def _takes(part: Part, slot: Slot) -> bool:
    if slot.control_mode not in part.modes:
        return False
    if slot.joint_names is not None:
        return set(slot.joint_names) <= set(part.joints)
    return slot.ee is None or part.end_effector == slot.ee


def _route(slot: Slot, robot: RobotManifest, part: Part) -> Route:
    mode = slot.mode
    assert mode is not None
    if slot.joint_names is not None:
        columns = tuple(robot.joint_names.index(name) for name in slot.joint_names)
    else:
        columns = slot.axes or tuple(range(slot.width))
    twist_frame = robot.base_frame if mode is ControlMode.BODY_TWIST else ""
    sources = tuple(range(slot.first, slot.last + 1))
    decides = slot.threshold is not None and mode is not ControlMode.GRIPPER_BINARY
    fit = SlotFit(slot.name, sources, slot.clip, slot.threshold if decides else None)
    return Route(
        part=robot.part_names.index(part.name),
        part_name=part.name,
        mode=mode,
        frame_id=slot.frame or twist_frame,
        width=mode.width(robot.n_dof),
        sources=sources,
        columns=columns,
        scale=slot.scales(),
        offset=slot.offsets(),
        in_units=slot.in_units(),
        active=tuple(sorted(columns)) if mode.is_joint_mode else (),
        threshold=None if decides else slot.threshold,
        fits=(fit,) if slot.clip is not None or decides else (),
    )


def _merged(one: Route, two: Route) -> Route:
    return Route(
        part=one.part,
        part_name=one.part_name,
        mode=one.mode,
        frame_id=one.frame_id,
        width=one.width,
        sources=one.sources + two.sources,
        columns=one.columns + two.columns,
        scale=one.scale + two.scale,
        offset=one.offset + two.offset,
        in_units=one.in_units + two.in_units,
        active=tuple(sorted(one.active + two.active)),
        fits=one.fits + two.fits,
    )
