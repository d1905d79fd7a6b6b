"""Where a skill's state vector comes from: layouts (shapes) and bindings (sources).

A layout names a shape and a meaning; the bindings name the frames and joints of the
robot that fill it. `StateLayout` is closed: a new layout is one literal here, one row in
each table below, and one assembler file.
"""

from __future__ import annotations

from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

StateLayout = Literal["human300_16d", "mobile_pick_30d"]

LAYOUT_DIMS: dict[StateLayout, int] = {"human300_16d": 16, "mobile_pick_30d": 30}
"""Numbers in each layout's vector."""

_TASK_SPACE = ("eef_frame", "base_frame", "world_frame", "gripper_qpos_joints")

REQUIRED_BINDINGS: dict[StateLayout, tuple[str, ...]] = {
    "human300_16d": _TASK_SPACE,
    "mobile_pick_30d": (*_TASK_SPACE, "object_frame", "goal_frame"),
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
        quaternion_convention: order of the four numbers of every quaternion.
        object_frame: the object to be picked.
        goal_frame: where it is to be placed.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    eef_frame: str | None = Field(default=None, min_length=1)
    eef_rotation_frame: str | None = Field(default=None, min_length=1)
    base_frame: str | None = Field(default=None, min_length=1)
    world_frame: str | None = Field(default="map", min_length=1)
    gripper_qpos_joints: tuple[str, ...] = ()
    quaternion_convention: Literal["xyzw", "wxyz"] = "xyzw"
    object_frame: str | None = Field(default=None, min_length=1)
    goal_frame: str | None = Field(default=None, min_length=1)

    @model_validator(mode="after")
    def _check_gripper(self) -> Self:
        joints = self.gripper_qpos_joints
        if len(joints) > 2 or len(set(joints)) != len(joints) or "" in joints:
            raise ValueError(
                "gripper_qpos_joints: expected two different joints, or one to be mirrored, "
                f"got {list(joints)}"
            )
        return self


class StateContract(BaseModel):
    """The state vector a policy was trained on: its layout, its size, its sources."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    layout: StateLayout
    dim: int
    bindings: StateContractBindings = StateContractBindings()

    @model_validator(mode="after")
    def _check_layout(self) -> Self:
        problems = []
        if self.dim != LAYOUT_DIMS[self.layout]:
            problems.append(
                f"dim: expected {LAYOUT_DIMS[self.layout]} for layout {self.layout}, got {self.dim}"
            )
        missing = missing_bindings(self.layout, self.bindings)
        if missing:
            problems.append(f"bindings: layout {self.layout} also needs {', '.join(missing)}")
        if problems:
            raise ValueError("; ".join(problems))
        return self


def missing_bindings(layout: StateLayout, bindings: StateContractBindings) -> list[str]:
    """Every field ``layout`` needs that ``bindings`` leaves empty, in table order."""
    return [name for name in REQUIRED_BINDINGS[layout] if not getattr(bindings, name)]
