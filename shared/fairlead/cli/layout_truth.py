"""What the simulator itself says about each field of a layout.

Truth comes from robosuite's own observation code and body poses; the layouts never use
them. robosuite's observations are one physics step (2 ms) behind its joint positions, so
they are read again after the simulator has been brought up to date.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateLayout

FieldKind = Literal["position", "quaternion", "axis-angle", "gripper", "joints"]

Truth = Mapping[str, FloatArray]
"""By field: xyz [m], quaternion xyzw, two fingers [m], or arm joints [rad]."""

_WIDTHS: dict[FieldKind, int] = {
    "position": 3,
    "quaternion": 4,
    "axis-angle": 3,
    "gripper": 2,
    "joints": 7,
}


@dataclass(frozen=True)
class Field:
    """One field of a layout.

    Attributes:
        first: index of its first number in the vector.
        bindings: the bindings it is made from.
    """

    name: str
    kind: FieldKind
    first: int
    bindings: tuple[str, ...]

    @property
    def width(self) -> int:
        """How many numbers of the vector this field has."""
        return _WIDTHS[self.kind]

    @property
    def is_rotation(self) -> bool:
        """Whether it is compared as an angle."""
        return self.kind in ("quaternion", "axis-angle")


def _base_and_eef(world: str) -> tuple[Field, ...]:
    """Where ``world`` is the simulator's world, or ``odom``, where the base started."""
    return (
        Field("base_to_eef position", "position", 0, ("eef_frame", "base_frame")),
        Field("base_to_eef rotation", "quaternion", 3, ("eef_rotation_frame", "base_frame")),
        Field(f"{world}_to_base position", "position", 7, ("world_frame", "base_frame")),
        Field(f"{world}_to_base rotation", "quaternion", 10, ("world_frame", "base_frame")),
        Field("gripper", "gripper", 14, ("gripper_qpos_joints",)),
    )


_HUMAN300 = _base_and_eef("world")

LAYOUT_FIELDS: dict[StateLayout, tuple[Field, ...]] = {
    "human300_16d": _HUMAN300,
    "rc365": _HUMAN300,
    "mobile_pick_30d": (
        *_base_and_eef("odom"),
        Field("base_to_object position", "position", 16, ("object_frame", "base_frame")),
        Field("base_to_object rotation", "quaternion", 19, ("object_frame", "base_frame")),
        Field("base_to_goal position", "position", 23, ("goal_frame", "base_frame")),
        Field("base_to_goal rotation", "quaternion", 26, ("goal_frame", "base_frame")),
    ),
    "libero_eef8d": (
        Field("world_to_eef position", "position", 0, ("eef_frame", "world_frame")),
        Field("world_to_eef rotation", "axis-angle", 3, ("eef_rotation_frame", "world_frame")),
        Field("gripper", "gripper", 6, ("gripper_qpos_joints",)),
    ),
    "libero": (
        Field("arm joints", "joints", 0, ("joint_names",)),
        Field("gripper", "gripper", 7, ("gripper_qpos_joints",)),
    ),
}
"""Every field of every layout that the simulator knows the truth of."""

_OBSERVATION_KEYS = {
    "base_to_eef position": "robot0_base_to_eef_pos",
    "base_to_eef rotation": "robot0_base_to_eef_quat",
    "world_to_base position": "robot0_base_pos",
    "world_to_base rotation": "robot0_base_quat",
    "world_to_eef position": "robot0_eef_pos",
    "world_to_eef rotation": "robot0_eef_quat",
    "arm joints": "robot0_joint_pos",
    "gripper": "robot0_gripper_qpos",
}


def verifiable_fields(layout: StateLayout) -> tuple[Field, ...]:
    """The fields of ``layout``.

    Raises:
        ConfigError: if the simulator has no truth for it.
    """
    fields = LAYOUT_FIELDS.get(layout)
    if fields is None:
        raise ConfigError(
            expected("layout verify", "a layout the simulator has truth for", layout, LAYOUT_FIELDS)
        )
    return fields


def read_truth(env: Any) -> Truth:
    """Every field's true value in a robosuite environment, at its newest joint positions."""
    env.sim.forward()
    observed = env._get_observations(force_update=True)
    truth = {field: np.asarray(observed[key]) for field, key in _OBSERVATION_KEYS.items()}
    return truth | _relative(env, truth)


def _relative(env: Any, robot: Truth) -> dict[str, FloatArray]:
    """The base in the body it drives on, and tracked bodies in the base.

    By robosuite's own arithmetic.
    """
    from robosuite.utils import transform_utils

    make: Callable[[tuple[FloatArray, FloatArray]], FloatArray] = transform_utils.pose2mat
    base = make((robot["world_to_base position"], robot["world_to_base rotation"]))
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


def field_error(field: Field, order: str, values: FloatArray, truth: Truth) -> float:
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


def sign_differs(field: Field, order: str, values: FloatArray, truth: Truth) -> bool:
    """Whether a rotation is the simulator's quaternion with the opposite sign."""
    if not field.is_rotation:
        return False
    return bool(_rotation(field, order, values) @ truth[field.name] < 0.0)


def _rotation(field: Field, order: str, values: FloatArray) -> FloatArray:
    """A rotation field as a quaternion xyzw, with the sign it was made from."""
    got = values[field.first : field.first + field.width]
    if field.kind == "quaternion":
        return got if order == "xyzw" else np.roll(got, -1)
    angle = float(np.linalg.norm(got))
    # sinc: sin(angle / 2) / angle without a division by zero.
    return np.append(got * (0.5 * np.sinc(0.5 * angle / np.pi)), np.cos(0.5 * angle))
