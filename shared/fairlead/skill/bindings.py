"""Where a skill's state vector comes from: layouts (shapes) and bindings (sources).

A layout names a shape and a meaning; the bindings name the frames and joints of the
robot that fill it. `StateLayout` is closed: a new layout is one name here, one row in
`LAYOUTS`, and one assembler file.
"""

from __future__ import annotations

from typing import Literal, NamedTuple, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from fairlead.frames import MAP
from fairlead.skill.joint_field import JointField, joint_field_problems

StateLayout = Literal[
    "human300_16d",
    "rc365",
    "mobile_pick_30d",
    "libero_eef8d",
    "base_pose_6d",
    "libero",
    "aloha",
    "gr1",
]

PoseBinding = Literal["eef_frame", "base_frame", "object_frame", "goal_frame"]

QuaternionSign = Literal["+w", "-w", "+x", "-x", "+y", "-y", "+z", "-z"]


class LayoutShape(NamedTuple):
    """One layout's row.

    Attributes:
        dim: numbers in its vector; None for a layout that nothing assembles.
        required: binding fields it cannot do without.
        joint_names: joints of a joint-space layout unless the bindings name others.
        gripper_qpos_joints: likewise its fingers.
    """

    dim: int | None
    required: tuple[str, ...] = ()
    joint_names: tuple[str, ...] = ()
    gripper_qpos_joints: tuple[str, ...] = ()


_BASE_AND_EEF = ("eef_frame", "base_frame", "world_frame", "gripper_qpos_joints")

# The names the datasets were recorded with: Franka's own, and ALOHA's.
_FRANKA_ARM = tuple(f"panda_joint{number}" for number in range(1, 8))
_FRANKA_FINGERS = ("panda_finger_joint1", "panda_finger_joint2")
_ALOHA_JOINTS = tuple(
    f"{side}_{joint}"
    for side in ("left", "right")
    for joint in (
        *("waist", "shoulder", "elbow", "forearm_roll", "wrist_angle", "wrist_rotate"),
        "gripper",
    )
)

LAYOUTS: dict[StateLayout, LayoutShape] = {
    "human300_16d": LayoutShape(16, _BASE_AND_EEF),
    "rc365": LayoutShape(16, _BASE_AND_EEF),
    "mobile_pick_30d": LayoutShape(30, (*_BASE_AND_EEF, "object_frame", "goal_frame")),
    "libero_eef8d": LayoutShape(8, ("eef_frame", "world_frame", "gripper_qpos_joints")),
    "base_pose_6d": LayoutShape(6, ("base_frame", "world_frame")),
    "libero": LayoutShape(9, (), _FRANKA_ARM, _FRANKA_FINGERS),
    "aloha": LayoutShape(14, (), _ALOHA_JOINTS),
    "gr1": LayoutShape(None, _BASE_AND_EEF),
}
"""Every layout's row."""

LAYOUT_DIMS: dict[StateLayout, int] = {
    name: shape.dim for name, shape in LAYOUTS.items() if shape.dim is not None
}
"""Numbers in the vector of each layout that can be assembled."""

REQUIRED_BINDINGS: dict[StateLayout, tuple[str, ...]] = {
    name: shape.required for name, shape in LAYOUTS.items()
}
"""Binding fields a layout cannot do without."""


class StateContractBindings(BaseModel):
    """Frames and joints of the deploying robot that fill a layout.

    Attributes:
        eef_frame: frame whose origin is the end effector's position.
        eef_rotation_frame: frame of the end effector's rotation; None means `eef_frame`
            (robosuite reports the grip site's position with the hand body's rotation).
        base_frame: frame that end-effector and object poses are given in.
        world_frame: frame the base's pose is given in.
        gripper_qpos_joints: two joints, or one that is mirrored as ``[v, -v]``.
        joint_names: the joints of a joint-space layout, in its order; empty for the
            names its dataset was recorded with.
        quaternion_convention: order of the four numbers of every quaternion.
        quaternion_signs: by frame, the number of its quaternion that is never negative
            (``+``) or never positive (``-``), for checkpoints trained so. Frames not
            named have w >= 0. Axis-angle vectors are made from the same quaternion.
        object_frame: the object to be picked.
        goal_frame: where it is to be placed.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    eef_frame: str | None = Field(default=None, min_length=1)
    eef_rotation_frame: str | None = Field(default=None, min_length=1)
    base_frame: str | None = Field(default=None, min_length=1)
    world_frame: str | None = Field(default=MAP, min_length=1)
    gripper_qpos_joints: tuple[str, ...] = ()
    joint_names: tuple[str, ...] = ()
    quaternion_convention: Literal["xyzw", "wxyz"] = "xyzw"
    quaternion_signs: dict[PoseBinding, QuaternionSign] = Field(default_factory=dict)
    object_frame: str | None = Field(default=None, min_length=1)
    goal_frame: str | None = Field(default=None, min_length=1)

    @model_validator(mode="after")
    def _check_joints(self) -> Self:
        joints = self.gripper_qpos_joints
        if len(joints) > 2 or len(set(joints)) != len(joints) or "" in joints:
            raise ValueError(
                "gripper_qpos_joints: expected two different joints, or one to be mirrored, "
                f"got {list(joints)}"
            )
        names = self.joint_names
        if len(set(names)) != len(names) or "" in names:
            raise ValueError(f"joint_names: expected different joints, got {list(names)}")
        return self


class StateContract(BaseModel):
    """The state vector a policy was trained on: its size, and what each number is.

    Attributes:
        layout: what the numbers mean, for a vector with poses in it; or
        joints: for one of joints alone, what is side by side in it.
        bindings: which frames and joints of the robot fill a layout.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    layout: StateLayout | None = None
    dim: int
    bindings: StateContractBindings = StateContractBindings()
    joints: tuple[JointField, ...] = ()

    @field_validator("layout", mode="before")
    @classmethod
    def _known_layout(cls, value: object) -> object:
        if value is not None and (not isinstance(value, str) or value not in LAYOUTS):
            raise ValueError(f"expected a layout, got {value!r} (valid: {', '.join(LAYOUTS)})")
        return value

    @property
    def layout_name(self) -> str:
        """What messages and errors call it."""
        return self.layout or "joints"

    @model_validator(mode="after")
    def _check_layout(self) -> Self:
        if self.layout is None or self.joints:
            problems = self._joint_space_problems()
        else:
            problems = self._layout_problems(self.layout)
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _joint_space_problems(self) -> list[str]:
        if not self.joints:
            return [f"expected layout or joints, got neither (valid layouts: {', '.join(LAYOUTS)})"]
        given = {"layout": self.layout, "bindings": self.bindings.model_dump(exclude_defaults=True)}
        problems = [f"{name}: not allowed beside joints" for name, value in given.items() if value]
        return problems + joint_field_problems(self.dim, self.joints)

    def _layout_problems(self, layout: StateLayout) -> list[str]:
        shape = LAYOUTS[layout]
        problems = []
        if shape.dim is not None and self.dim != shape.dim:
            problems.append(f"dim: expected {shape.dim} for layout {layout}, got {self.dim}")
        missing = missing_bindings(layout, self.bindings)
        if missing:
            problems.append(f"bindings: layout {layout} also needs {', '.join(missing)}")
        return problems + _unread(layout, self.bindings)


def missing_bindings(layout: StateLayout, bindings: StateContractBindings) -> list[str]:
    """Every field ``layout`` needs that ``bindings`` leaves empty, in table order."""
    return [name for name in REQUIRED_BINDINGS[layout] if not getattr(bindings, name)]


def bound_joints(layout: StateLayout, bindings: StateContractBindings) -> tuple[str, ...]:
    """The joints a joint-space layout reads, in its order; fingers are not among them."""
    return bindings.joint_names or LAYOUTS[layout].joint_names


def bound_gripper(layout: StateLayout, bindings: StateContractBindings) -> tuple[str, ...]:
    """The joints a layout reads its fingers from."""
    return bindings.gripper_qpos_joints or LAYOUTS[layout].gripper_qpos_joints


def _unread(layout: StateLayout, bindings: StateContractBindings) -> list[str]:
    """What is bound in vain: it would be a surprise if it were ignored."""
    shape, problems = LAYOUTS[layout], []
    wanted, named = len(shape.joint_names), len(bindings.joint_names)
    if named not in (0, wanted):
        problems.append(f"joint_names: expected {wanted} for layout {layout}, got {named}")
    reads_gripper = shape.gripper_qpos_joints or "gripper_qpos_joints" in shape.required
    if bindings.gripper_qpos_joints and not reads_gripper:
        problems.append(f"gripper_qpos_joints: layout {layout} reads none")
    problems += [
        f"quaternion_signs: layout {layout} has no rotation of {name}"
        for name in bindings.quaternion_signs
        if name not in shape.required
    ]
    return problems
