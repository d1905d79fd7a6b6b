"""What the simulator itself says about each field of a layout.

Truth comes from robosuite's own observation code and body poses; the layouts never use
them. robosuite's observations are one physics step (2 ms) behind its joint positions, so
they are read again after the simulator has been brought up to date.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np

from fairlead.errors import ConfigError
from fairlead.layout import LayoutField, load_layout
from fairlead.messages import FloatArray

Truth = Mapping[str, FloatArray]
"""By field: xyz [m], quaternion xyzw, two fingers [m], or arm joints [rad]."""

_BASE = "world_to_base position"
_OBSERVATION_KEYS = {
    "base_to_eef position": "robot0_base_to_eef_pos",
    "base_to_eef rotation": "robot0_base_to_eef_quat",
    _BASE: "robot0_base_pos",
    "world_to_base rotation": "robot0_base_quat",
    "world_to_eef position": "robot0_eef_pos",
    "world_to_eef rotation": "robot0_eef_quat",
    "arm joints": "robot0_joint_pos",
    "arm joints' cosines": "robot0_joint_pos_cos",
    "arm joints' sines": "robot0_joint_pos_sin",
    "arm joints' velocities": "robot0_joint_vel",
    "gripper": "robot0_gripper_qpos",
    "gripper velocities": "robot0_gripper_qvel",
}


def verifiable_fields(name: str) -> tuple[LayoutField, ...]:
    """The fields of a layout that the simulator knows the truth of.

    Raises:
        ConfigError: if there are none.
    """
    fields = load_layout(name).fields
    if not fields:
        raise ConfigError(
            f"layout verify: layout {name} names no fields that the simulator knows the truth of"
        )
    return fields


def read_truth(env: Any, fields: Collection[LayoutField]) -> Truth:
    """Every field's true value in a robosuite environment, at its newest joint positions.

    Raises:
        ConfigError: the environment observes one of ``fields`` for no robot of this kind: an arm
            on a table has no base that drives.
    """
    env.sim.forward()
    observed = env._get_observations(force_update=True)
    truth = {
        field: np.asarray(observed[key])
        for field, key in _OBSERVATION_KEYS.items()
        if key in observed
    }
    if _BASE in truth:
        truth |= _relative(env, truth)
    unseen = [field.name for field in fields if field.name not in truth]
    if unseen:
        raise ConfigError(
            "layout verify: expected a simulation that observes all of the layout, got one of "
            f"{env.robots[0].name} without {', '.join(unseen)}"
        )
    return truth


def _relative(env: Any, robot: Truth) -> dict[str, FloatArray]:
    """The base in the body it drives on, and tracked bodies in the base.

    By robosuite's own arithmetic.
    """
    from robosuite.utils import transform_utils

    make: Callable[[tuple[FloatArray, FloatArray]], FloatArray] = transform_utils.pose2mat
    base = make((robot[_BASE], robot["world_to_base rotation"]))
    found: dict[str, FloatArray] = {}

    def add(field: str, pose: FloatArray, parent: FloatArray) -> None:
        seen = transform_utils.pose_in_A_to_pose_in_B(pose, transform_utils.pose_inv(parent))
        position, rotation = transform_utils.mat2pose(seen)
        found[f"{field} position"], found[f"{field} rotation"] = position, rotation

    def placed(body: str) -> FloatArray:
        index = env.sim.model.body_name2id(body)
        rotation = transform_utils.convert_quat(env.sim.data.body_xquat[index], to="xyzw")
        return make((env.sim.data.body_xpos[index], rotation))

    add("odom_to_base", base, placed(env.robots[0].robot_model.root_body))
    for frame, body in getattr(env, "tracked_bodies", dict)().items():
        add(f"base_to_{frame}", placed(body), base)
    return found


def field_error(field: LayoutField, order: str, values: FloatArray, truth: Truth) -> float:
    """How far one field is from the truth [m], or [rad] for a rotation or joints.

    Args:
        order: ``xyzw`` or ``wxyz``, the order of the layout's quaternions.
        values: the whole layout vector.
    """
    wanted = truth[field.name]
    if not field.is_rotation:
        got = values[field.first : field.first + field.width]
        return float(np.max(np.abs(got - wanted)))
    xyzw = _rotation(field, order, values)
    # The sine of half the angle between them: exact for small angles, unlike arccos.
    conjugate = np.append(-wanted[:3], wanted[3])
    vector = xyzw[3] * conjugate[:3] + conjugate[3] * xyzw[:3] + np.cross(xyzw[:3], conjugate[:3])
    scalar = xyzw[3] * conjugate[3] - xyzw[:3] @ conjugate[:3]
    return float(2.0 * np.arctan2(np.linalg.norm(vector), abs(scalar)))


def sign_differs(field: LayoutField, order: str, values: FloatArray, truth: Truth) -> bool:
    """Whether a rotation is the simulator's quaternion with the opposite sign."""
    if not field.is_rotation:
        return False
    return bool(_rotation(field, order, values) @ truth[field.name] < 0.0)


def _rotation(field: LayoutField, order: str, values: FloatArray) -> FloatArray:
    """A rotation field as a quaternion xyzw, with the sign it was made from."""
    got = values[field.first : field.first + field.width]
    if field.kind == "quaternion":
        return got if order == "xyzw" else np.roll(got, -1)
    angle = float(np.linalg.norm(got))
    # sinc: sin(angle / 2) / angle without a division by zero.
    return np.append(got * (0.5 * np.sinc(0.5 * angle / np.pi)), np.cos(0.5 * angle))
