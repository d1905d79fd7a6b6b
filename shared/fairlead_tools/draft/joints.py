"""What the files say of each joint, and what has to be assumed."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead_tools.draft.derived_urdf import (
    ANY,
    effort_limit,
    is_position_servo,
    position_range,
)
from fairlead_tools.draft.source_model import WHO, SourceModel

_TYPES = ("revolute", "continuous", "prismatic")
_SPEED = {"rad": 1.0, "m": 0.1}  # assumed where no file says one [per s]
_REACHED_IN_S = 0.2  # assumed: the time to full speed
_EFFORT = {"rad": 10.0, "m": 20.0}  # assumed [N m, N]
_POSES = 200
_MOST_RAD = 25.0
"""Of a turning joint's limits and speed: what is more was meant in degrees."""
_MOST_M = 10.0
"""Between two joints, and of a sliding one's limits and speed: what is more was meant in mm."""


@dataclass(frozen=True)
class DraftJoint:
    """One joint with a limit for everything, in joint units (rad or m).

    model_joints: what the model calls it; two are the fingers of an opening.
    lower, upper: None where it turns without end.
    lag_s, sag: how far its servo stays behind: time at speed, and what gravity and friction add.
    open: of each number that no file says, by the name of its key: why it may be wrong.
    """

    name: str
    type: str
    parent: str
    child: str
    commanded: bool
    lower: float | None
    upper: float | None
    velocity: float
    acceleration: float
    effort: float
    source: str
    model_joints: tuple[str, ...] = ()
    lag_s: float = 0.0
    sag: float = 0.0
    open: Mapping[str, str] = field(default_factory=dict)

    @property
    def unit(self) -> str:
        """``rad`` or ``m``."""
        return "m" if self.type == "prismatic" else "rad"

    @property
    def span(self) -> float:
        """From one end to the other; without ends a turn."""
        if self.lower is None or self.upper is None:
            return 2.0 * math.pi
        return self.upper - self.lower

    @property
    def lag(self) -> float:
        """How far it is behind its target at full speed."""
        return self.velocity * self.lag_s + self.sag


def moving_joints(urdf: ET.Element) -> list[ET.Element]:
    """The joints of a URDF that move by themselves, in its order: none that mimics another."""
    return [
        one
        for one in urdf.findall("joint")
        if one.get("type") != "fixed" and one.find("mimic") is None
    ]


def draft_joints(
    urdf: ET.Element, name: str, source: SourceModel | None, same: Mapping[str, int]
) -> list[DraftJoint]:
    """Every joint that moves.

    Args:
        name: of the file that is cited.
        same: number of the model's joint, by the URDF's name.

    Raises:
        ConfigError: naming the joint: a limit that is no number, or nothing.
    """
    sags = {} if source is None else gravity_sags(source)
    drives = source is not None and any(source.actuators(j) for j in source.joints)
    return [
        _draft(joint, name, source, same.get(joint.get("name", "")), sags, drives)
        for joint in moving_joints(urdf)
    ]


def _check_range(lower: float | None, upper: float | None, who: str) -> None:
    if lower is None or upper is None or not lower < upper:
        got = "none" if lower is None or upper is None else f"{lower:g} to {upper:g}"
        raise ConfigError(expected(f"{who}: lower and upper", "a range", got))


def _draft(
    joint: ET.Element, file: str, source: SourceModel | None, number: int | None,
    sags: Mapping[int, float], drives: bool,
) -> DraftJoint:  # fmt: skip
    name, kind = joint.get("name", ""), joint.get("type", "")
    who = f"{WHO}: {file}: joint {name!r}"
    if kind not in _TYPES:
        what = "one that turns about, or slides along, one axis"
        raise ConfigError(expected(f"{who}: type", what, repr(kind), (*_TYPES, "fixed")))
    told = {key: _limit(joint, key, who) for key in ("lower", "upper", "effort", "velocity")}
    _check_place(joint, who)
    unit = "m" if kind == "prismatic" else "rad"
    soft = {key: _limit(joint, f"soft_{key}_limit", who) for key in ("lower", "upper")}
    lower = max((v for v in (told["lower"], soft["lower"]) if v is not None), default=None)
    upper = min((v for v in (told["upper"], soft["upper"]) if v is not None), default=None)
    efforts = [told["effort"]] if told["effort"] is not None else []
    lag_s, bounds = 0.0, None
    if source is not None and number is not None:
        bounds = position_range(source, number)
        if bounds is not None:
            lower = bounds[0] if lower is None else max(lower, bounds[0])
            upper = bounds[1] if upper is None else min(upper, bounds[1])
        efforts += [one for one in (effort_limit(source, number),) if one is not None]
        lag_s = servo_lag_s(source, number)
    if kind == "continuous":  # unless the MJCF has end stops
        kind, (lower, upper) = ("revolute", bounds) if bounds else (kind, (None, None))
    else:
        _check_range(lower, upper, who)
    velocity = told["velocity"] or _SPEED[unit]
    open_, effort = {}, min(efforts, default=_EFFORT[unit])
    if told["velocity"] is None:
        open_["velocity"] = "assumed, no file says it: see the data sheet"
    open_["acceleration"] = f"assumed: full speed in {_REACHED_IN_S:g} s"
    if not efforts:
        open_["effort"] = "assumed, no file says it: see the data sheet"
    links = [_link(joint, tag, who) for tag in ("parent", "child")]
    driven = not drives or source is None or number is None or bool(source.actuators(number))
    model_joints = () if source is None or number is None else (source.model.joint(number).name,)
    return DraftJoint(
        name, kind, links[0], links[1], driven, lower, upper, velocity,
        _rounded(velocity / _REACHED_IN_S), effort, file, model_joints, lag_s,
        sags.get(-1 if number is None else number, 0.0), open_,
    )  # fmt: skip


def _limit(joint: ET.Element, key: str, who: str) -> float | None:
    limit = joint.find("safety_controller" if key.startswith("soft") else "limit")
    text = None if limit is None else limit.get(key)
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ConfigError(expected(f"{who}: limit {key}", "a number", repr(text)))
    if key in ("effort", "velocity") and not value > 0.0:
        raise ConfigError(expected(f"{who}: limit {key}", "a number above 0", repr(text)))
    if abs(value) >= ANY:
        return None
    what, most, meant = {
        "revolute": (
            f"rad, or rad/s, up to {_MOST_RAD:g}; a joint without an end is continuous",
            _MOST_RAD, "degrees",
        ),
        "prismatic": (f"m, or m/s, up to {_MOST_M:g}", _MOST_M, "mm"),
    }.get(joint.get("type", ""), ("", math.inf, ""))  # fmt: skip
    if key != "effort" and abs(value) > most:
        raise ConfigError(expected(f"{who}: limit {key}", what, f"{value:g}: are these {meant}?"))
    return value


def _check_place(joint: ET.Element, who: str) -> None:
    origin = joint.find("origin")
    text = "" if origin is None else origin.get("xyz", "")
    try:
        furthest = max((abs(float(word)) for word in text.split()), default=0.0)
    except ValueError:
        return  # the description's reader says so
    if furthest > _MOST_M:
        what = f"metres, up to {_MOST_M:g}"
        raise ConfigError(expected(f"{who}: origin xyz", what, f"{text}: are these mm?"))


def _link(joint: ET.Element, tag: str, who: str) -> str:
    found = joint.find(tag)
    if found is None or not found.get("link"):
        raise ConfigError(f"{who}: expected a {tag} link")
    return found.get("link", "")


def _servo(source: SourceModel, joint: int) -> int | None:
    found = [a for a in source.actuators(joint) if is_position_servo(source.model, a)]
    return found[0] if len(found) == 1 else None


def servo_lag_s(source: SourceModel, joint: int) -> float:
    """How long a servo's joint stays behind a target that moves: damping over stiffness."""
    servo, model = _servo(source, joint), source.model
    if servo is None:
        return 0.0
    damping = float(model.dof_damping[model.jnt_dofadr[joint]] - model.actuator_biasprm[servo, 2])
    return max(0.0, damping / float(model.actuator_gainprm[servo, 0]))


def gravity_efforts(source: SourceModel) -> dict[int, float]:
    """What gravity and friction take of each joint: the most of random poses [N m or N]."""
    model, data = source.model, mujoco.MjData(source.model)
    rng, force = np.random.default_rng(0), np.zeros(model.nv)
    for _ in range(_POSES):
        data.qpos[:] = model.qpos0
        for joint in source.joints:
            low, high = position_range(source, joint) or (-math.pi, math.pi)
            data.qpos[model.jnt_qposadr[joint]] = rng.uniform(low, high)
        mujoco.mj_forward(model, data)
        force = np.maximum(force, np.abs(data.qfrc_bias - data.qfrc_gravcomp))
    dofs = {joint: int(model.jnt_dofadr[joint]) for joint in source.joints}
    return {one: float(force[dof] + model.dof_frictionloss[dof]) for one, dof in dofs.items()}


def gravity_sags(source: SourceModel) -> dict[int, float]:
    """How far gravity and friction push each joint off its servo's target [rad or m]."""
    servos = {joint: _servo(source, joint) for joint in source.joints}
    gains, efforts = source.model.actuator_gainprm, gravity_efforts(source)
    return {one: efforts[one] / float(gains[at, 0]) for one, at in servos.items() if at is not None}


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")


def same_joints(urdf: ET.Element, source: SourceModel) -> dict[str, int]:
    """Number of the model's joint for each of a URDF that moves, by their names.

    A name may have a prefix, or the model's suffix; how both move says later if it was right.

    Raises:
        ConfigError: the model has none of a name, or several.
    """
    names = {joint: str(source.model.joint(joint).name) for joint in source.joints}
    return {one.get("name", ""): _same(one.get("name", ""), names) for one in moving_joints(urdf)}


def joints_called(name: str, names: Mapping[int, str]) -> Sequence[int]:
    """Numbers of the model's joints that may be the URDF's of this name."""
    exact = [joint for joint, called in names.items() if called == name]
    return exact or [
        joint for joint, called in names.items()
        if called.endswith(name) or called.startswith(name) or name.endswith(called)
    ]  # fmt: skip


def _same(name: str, names: Mapping[int, str]) -> int:
    found = joints_called(name, names)
    if len(found) != 1:
        who = f"{WHO}: joint {name!r} of the URDF"
        what = "one joint of its name in the MJCF"
        raise ConfigError(
            expected(who, what, str(len(found)), names.values()) + "; or leave out --urdf"
        )
    return found[0]
