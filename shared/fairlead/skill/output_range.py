"""What a policy's outputs of -1 and +1 become, against what the robot takes.

A policy may emit anything in [-1, 1], or in the range its numbers are clipped to; a slot's scale
and offset make SI of them. Modes that say where something is to be may also come in their unit,
without a scale.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from fairlead.messages import HalStatus, floats
from fairlead.modes import ControlMode
from fairlead.robot.command_ranges import command_range, norm_limits
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.routes import Route

# A policy may emit these in SI or degrees, without a scale; their full scale is not +-1.
_ABSOLUTE_MODES = frozenset(
    {
        ControlMode.JOINT_POSITION,
        ControlMode.CARTESIAN_POSE,
        ControlMode.DEX_HAND_JOINT,
        ControlMode.GRIPPER_BINARY,
    }
)
_RELATIVE_TOLERANCE = 1e-9
_SAME = 1e-6  # relative: the HAL's range comes from the norm in the robot's manifest


class _Range(NamedTuple):
    """Lower and upper ends of a part's values in a control period, in SI, and who says so."""

    lower: Sequence[float]
    upper: Sequence[float]
    who: str
    periods: int  # that a row of the policy is divided among


def _periods(route: Route, policy_periods: int) -> int:
    return policy_periods if route.mode.adds_up else 1


class _Excess(NamedTuple):
    """Full scale of a value, what is taken instead, and the norm behind it as words."""

    full: tuple[float, float]
    taken: tuple[float, float]
    norm: str


def hal_range_problems(
    routes: Sequence[Route], robot: RobotManifest, hal: HalStatus, policy_periods: int
) -> list[str]:
    """Every value whose full scale leaves the range that the running HAL states.

    Args:
        policy_periods: control periods for one row of the policy.
    """
    problems = []
    for route in routes:
        stated = [block for block in hal.parts[route.part].ranges if block.mode == route.mode]
        if not stated:
            told = [one.mode for one in hal.parts[route.part].ranges]
            offered = [mode.yaml_name for mode in ControlMode if mode in told]
            problems.append(
                f"part {route.part_name}: the HAL does not offer {route.mode.yaml_name}"
                + (f", it offers {', '.join(offered)}" if offered else "")
            )
            continue
        lower, upper = floats(stated[0].lower).tolist(), floats(stated[0].upper).tolist()
        ends = _Range(lower, upper, "HAL", _periods(route, policy_periods))
        problems += _problems(route, robot, hal.parts[route.part].joints, ends)
    return problems


def declared_range_problems(
    routes: Sequence[Route], robot: RobotManifest, policy_periods: int
) -> list[str]:
    """Every value whose full scale leaves the range that the robot declares.

    Of several safety profiles the one that complains least: which one holds is a matter of
    the deployment.

    Args:
        policy_periods: control periods for one row of the policy.
    """
    found = [_in_profile(routes, robot, profile, policy_periods) for profile in robot.safety]
    return min(found, key=len, default=[])


def _in_profile(
    routes: Sequence[Route], robot: RobotManifest, profile: str, policy_periods: int
) -> list[str]:
    problems = []
    for route in routes:
        part = robot.part(route.part_name)
        limits = robot.profile(profile).parts[part.name]
        lower, upper = command_range(robot, part, route.mode, limits)
        periods = _periods(route, policy_periods)
        ends = _Range(lower.tolist(), upper.tolist(), "robot", periods)
        problems += _problems(route, robot, part.joints, ends)
    return problems


def _problems(route: Route, robot: RobotManifest, joints: Sequence[str], ends: _Range) -> list[str]:
    if route.threshold is not None:  # 0 or 1 comes out of it, whatever goes in
        return []
    where = f"part {route.part_name} {route.mode.yaml_name}"
    missing: list[str] = []
    excesses: dict[_Excess, list[int]] = {}
    numbers = zip(
        route.columns, route.scale, route.offset, route.in_units, _ends(route), strict=True
    )
    for column, scale, offset, in_units, outputs in numbers:
        if route.mode in _ABSOLUTE_MODES and in_units:
            continue
        # Ranges follow the part's joints, the wire follows the robot's.
        index = joints.index(robot.joint_names[column]) if route.mode.is_joint_mode else column
        if index >= len(ends.lower):
            missing.append(f"{where}: the {ends.who} states no range for value {index}")
            continue
        low, high = sorted(offset + scale * output for output in outputs)
        taken = (ends.lower[index] * ends.periods, ends.upper[index] * ends.periods)
        slack = _RELATIVE_TOLERANCE * max(abs(low), abs(high))
        if low < taken[0] - slack or high > taken[1] + slack:
            norm = _norm_words(robot, route, index, ends)
            excesses.setdefault(_Excess((low, high), taken, norm), []).append(index)
    return [*missing, *(f"{where} {_words(e, i, ends)}" for e, i in excesses.items())]


def _ends(route: Route) -> list[tuple[float, float]]:
    """Per source, the policy's lowest and highest number."""
    clips = {source: fit.clip for fit in route.fits if fit.clip for source in fit.sources}
    return [clips.get(source, (-1.0, 1.0)) for source in route.sources]


def _words(excess: _Excess, indices: Sequence[int], ends: _Range) -> str:
    values = ("value " if len(indices) == 1 else "values ") + ", ".join(map(str, indices))
    low, high = excess.full
    spread = f" in {ends.periods} control periods" if ends.periods > 1 else ""
    return (
        f"{values}: full-scale output is [{low:g}, {high:g}], the {ends.who} takes "
        f"[{excess.taken[0]:g}, {excess.taken[1]:g}]{spread}{excess.norm}; a policy's outputs are "
        f"taken as full scale [-1, 1], which the slot's scale makes SI: {_fitting(*excess.taken)}"
        f"{_degrees_words(low, high)}"
    )


def _degrees_words(low: float, high: float) -> str:
    """What somebody wants who scales by a degree."""
    is_degree = math.isclose(high - low, math.radians(2.0), rel_tol=1e-4)
    return "; for degrees write unit: deg and no scale" if is_degree else ""


def _norm_words(robot: RobotManifest, route: Route, index: int, ends: _Range) -> str:
    """Where a range is a norm's share of one axis: the norm, which is the known number."""
    for safety in robot.safety.values():
        limits = norm_limits(route.mode, safety.parts[route.part_name])
        for norm, unit in limits[index // 3 : index // 3 + 1]:
            share = norm / math.sqrt(3.0)
            if math.isclose(ends.upper[index], share, rel_tol=_SAME):
                most, each = norm * ends.periods, share * ends.periods
                return f" (a norm of {most:g} {unit} is {each:g} on each of three axes at once)"
    return ""


def _fitting(lower: float, upper: float) -> str:
    """The largest scale, and the offset it needs, whose full scale lies in a range."""
    offset = float(f"{(lower + upper) / 2:.6g}")
    reach = min(upper - offset, offset - lower)
    if reach <= 0.0:
        return "none fits, this value is to be discarded"
    beside = f" with offset {offset:g}" if offset else ""
    return f"scale {_rounded_down(reach):g}{beside} fits"


def _rounded_down(value: float) -> float:
    """Six digits, none of which is rounded up."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 5)
    nearest = float(f"{value:.6g}")
    return nearest if nearest <= value else float(f"{nearest - unit:.6g}")
