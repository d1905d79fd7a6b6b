"""A URDF with the kinematics of an MJCF model: its bodies are the links."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import mujoco
import numpy as np

from fairlead.messages import FloatArray
from fairlead_tools.draft.source_model import SourceModel

ANY = 1e6
"""A limit of a URDF that says: none is known."""
_DIGITS = 12


@dataclass(frozen=True)
class Pose:
    """A frame in another one: rotation ``[3, 3]`` and translation ``[3]`` [m]."""

    rotation: FloatArray
    translation: FloatArray

    def then(self, other: Pose) -> Pose:
        """A frame that this one carries."""
        return Pose(
            self.rotation @ other.rotation, self.rotation @ other.translation + self.translation
        )

    def inverse(self) -> Pose:
        """The other frame in this one."""
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)


def pose_of(quaternion_wxyz: FloatArray, translation: FloatArray) -> Pose:
    """A pose as MuJoCo tells it."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, quaternion_wxyz)
    return Pose(rotation.reshape(3, 3), np.array(translation))


def anchor(source: SourceModel, body: int) -> Pose:
    """The link of a body in the body's frame: it lies where the body's joint does."""
    joint = source.joint_of(body)
    place = np.zeros(3) if joint is None else np.array(source.model.jnt_pos[joint])
    return Pose(np.eye(3), place)


def derived_urdf(source: SourceModel, name: str, tools: dict[str, int]) -> str:
    """The URDF's text.

    Args:
        tools: sites that become links too, by name and number.
    """
    model = source.model
    root = str(model.body(source.base).name)
    lines = [
        '<?xml version="1.0"?>',
        f"<!-- Kinematics of {name}.xml, made of it by fairlead robot new. -->",
        f"<robot name={quoteattr(name)}>",
        f"  <link name={quoteattr(root)}/>",
    ]
    for body in source.bodies[1:]:
        lines += _link_of(source, body)
    for tool, site in tools.items():
        carrier = int(model.site_bodyid[site])
        place = pose_of(model.site_quat[site], model.site_pos[site])
        placed = anchor(source, carrier).inverse().then(place)
        lines += _link(tool, str(model.body(carrier).name), placed, f"{tool}_fixed", "fixed", [])
    return "\n".join([*lines, "</robot>", ""])


def _link_of(source: SourceModel, body: int) -> list[str]:
    model, joint = source.model, source.joint_of(body)
    parent, name = int(model.body_parentid[body]), str(model.body(body).name)
    placed = pose_of(model.body_quat[body], model.body_pos[body]).then(anchor(source, body))
    if parent != source.base or source.base:
        placed = anchor(source, parent).inverse().then(placed)
    above = str(model.body(parent).name)
    if joint is None:
        return _link(name, above, placed, f"{name}_fixed", "fixed", [])
    axis, reference = np.array(model.jnt_axis[joint]), float(model.qpos0[model.jnt_qposadr[joint]])
    slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE
    placed = placed.then(_at(axis, -reference, slides))
    limit = _limit(source, joint)
    kind = "prismatic" if slides else "revolute" if "lower" in limit else "continuous"
    inside = [f"    <axis {_xyz(axis)}/>", f"    {limit}", *_mimic(source, joint)]
    return _link(name, above, placed, str(model.joint(joint).name), kind, inside)


def _mimic(source: SourceModel, joint: int) -> list[str]:
    """A joint that an equality ties to another, in a line; [] where nothing or an actuator does."""
    model, kind = source.model, mujoco.mjtEq.mjEQ_JOINT
    for tie in range(model.neq):
        leads, follows = int(model.eq_obj2id[tie]), int(model.eq_obj1id[tie])
        first, ratio, *bends = (float(value) for value in model.eq_data[tie, :5])
        is_other = model.eq_type[tie] != kind or follows != joint or not model.eq_active0[tie]
        if is_other or leads < 0 or any(bends):
            continue
        if not source.actuators(joint):
            zero, leader_zero = (model.qpos0[model.jnt_qposadr[one]] for one in (joint, leads))
            offset = float(zero + first - ratio * leader_zero)
            name = quoteattr(str(model.joint(leads).name))
            return [f'    <mimic joint={name} multiplier="{ratio:.12g}" offset="{offset:.12g}"/>']
    return []


def _at(axis: FloatArray, position: float, slides: bool) -> Pose:
    if slides:
        return Pose(np.eye(3), axis * position)
    quaternion = np.zeros(4)
    mujoco.mju_axisAngle2Quat(quaternion, axis, position)
    return pose_of(quaternion, np.zeros(3))


def _limit(source: SourceModel, joint: int) -> str:
    bounds = position_range(source, joint)
    ends = "" if bounds is None else f'lower="{bounds[0]:.12g}" upper="{bounds[1]:.12g}" '
    effort = effort_limit(source, joint) or ANY
    return f'<limit {ends}effort="{effort:.12g}" velocity="{ANY:.12g}"/>'


def position_range(source: SourceModel, joint: int) -> tuple[float, float] | None:
    """Where a joint can be and be told to be; None: it turns without end."""
    model, ends = source.model, []
    if model.jnt_limited[joint]:
        ends.append(model.jnt_range[joint])
    ends += [
        np.sort(model.actuator_ctrlrange[one] / model.actuator_gear[one, 0])
        for one in source.actuators(joint)
        if model.actuator_ctrllimited[one]
        and is_position_servo(model, one)
        and model.actuator_gear[one, 0] != 0.0
    ]
    if not ends:
        return None
    return float(max(low for low, _ in ends)), float(min(high for _, high in ends))


def effort_limit(source: SourceModel, joint: int) -> float | None:
    """Largest effort of a joint's actuators [N m or N]; None where the model limits none."""
    model, found = source.model, []
    if model.jnt_actfrclimited[joint]:
        found.append(float(np.abs(model.jnt_actfrcrange[joint]).max()))
    found += [
        float(np.abs(model.actuator_forcerange[one]).max() * abs(model.actuator_gear[one, 0]))
        for one in source.actuators(joint)
        if model.actuator_forcelimited[one]
    ]
    found += [
        float(np.abs(model.actuator_ctrlrange[one]).max() * _motor_gain(model, one))
        for one in source.actuators(joint)
        if model.actuator_ctrllimited[one] and _motor_gain(model, one) > 0.0
    ]
    return min(found, default=None)


def _motor_gain(model: mujoco.MjModel, actuator: int) -> float:
    """Effort of a joint for each unit that its motor is told; 0 of what is no mere motor."""
    is_motor = (
        model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED
        and model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE
    )
    gain = abs(model.actuator_gainprm[actuator, 0] * model.actuator_gear[actuator, 0])
    return float(gain) if is_motor else 0.0


def is_position_servo(model: mujoco.MjModel, actuator: int) -> bool:
    """Whether an actuator drives its joint to the position it is told."""
    gain, bias = model.actuator_gainprm[actuator], model.actuator_biasprm[actuator]
    return bool(gain[0] > 0.0 and bias[1] == -gain[0])


def _link(
    name: str, parent: str, placed: Pose, joint: str, kind: str, inside: list[str]
) -> list[str]:
    return [
        "",
        f"  <link name={quoteattr(name)}/>",
        f'  <joint name={quoteattr(joint)} type="{kind}">',
        f"    <parent link={quoteattr(parent)}/>",
        f"    <child link={quoteattr(name)}/>",
        f'    <origin {_xyz(placed.translation)} rpy="{_words(_rpy(placed.rotation))}"/>',
        *inside,
        "  </joint>",
    ]


def _xyz(vector: FloatArray) -> str:
    return f'xyz="{_words(vector)}"'


def _words(vector: FloatArray) -> str:
    return " ".join(f"{round(float(value), _DIGITS) + 0.0:.12g}" for value in vector)


def _rpy(rotation: FloatArray) -> FloatArray:
    """Angles about the fixed axes x, then y, then z [rad]."""
    flat = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], flat)
    if flat > 1e-9:
        roll = math.atan2(rotation[2, 1], rotation[2, 2])
        return np.array([roll, pitch, math.atan2(rotation[1, 0], rotation[0, 0])])
    return np.array([math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0])
