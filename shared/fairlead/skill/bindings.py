"""Which frames and joints of a robot fill a state layout."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fairlead.frames import MAP

PoseBinding = Literal["eef_frame", "base_frame", "object_frame", "goal_frame"]

QuaternionSign = Literal["+w", "-w", "+x", "-x", "+y", "-y", "+z", "-z"]


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
