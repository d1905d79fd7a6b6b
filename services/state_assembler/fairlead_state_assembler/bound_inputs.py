"""What a layout reads of one tick, by the names of a skill's bindings."""

from __future__ import annotations

from typing import NoReturn, Protocol

import numpy as np
import pinocchio as pin

from fairlead.errors import LayoutError
from fairlead.frames import ODOM
from fairlead.layout import Layout, ParentBinding
from fairlead.messages import FloatArray
from fairlead.skill.bindings import PoseBinding, QuaternionSign, StateContractBindings
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_decoding import SE3
from fairlead_state_assembler.pose_vector import (
    axis_angle3,
    gripper_pair,
    pose7,
    position3,
    quaternion_xyzw,
    rotation4,
)

_POSITIVE: tuple[QuaternionSign, ...] = ("+x", "+y", "+z", "+w")
_NEGATIVE: tuple[QuaternionSign, ...] = ("-x", "-y", "-z", "-w")


class Transforms(Protocol):
    """What is asked of the transforms of a tick."""

    def pose(self, parent: str, child: str) -> SE3:
        """T_parent_child as a `pinocchio.SE3` [m]; raises `LayoutError`."""


class BoundInputs:
    """A `fairlead.layout.LayoutInputs`: joints and transforms of one tick, and the bindings.

    Args:
        name: of the layout, for errors.
    """

    def __init__(
        self,
        name: str,
        layout: Layout,
        bindings: StateContractBindings,
        joints: JointPositions,
        transforms: Transforms,
    ) -> None:
        self._name = name
        self._layout = layout
        self._bindings = bindings
        self._signs = bindings.quaternion_signs
        self._joints = joints
        self._transforms = transforms

    def position3(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """Where ``child`` is in ``parent``: shape ``[3]`` [m]."""
        return position3(self._pose(parent, child))

    def quaternion4(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """How ``child`` is turned in ``parent``: shape ``[4]``, unit quaternion."""
        order = self._bindings.quaternion_convention
        return rotation4(self._rotated(parent, child), order, self._signs.get(child, "+w"))

    def driven_quaternion4(self, child: PoseBinding, sign: QuaternionSign) -> FloatArray:
        """How ``child`` is turned in ``world_frame``: shape ``[4]``, unit quaternion.

        Args:
            sign: of ``child`` in the base.
        """
        world = self._bindings.world_frame or self._refuse("world_frame")
        product = (
            pin.Quaternion(quaternion_xyzw(self._transforms.pose(world, ODOM), "+w"))
            * pin.Quaternion(
                quaternion_xyzw(self.in_world(ODOM)._pose("world_frame", "base_frame"), "+w")
            )
            * pin.Quaternion(quaternion_xyzw(self._rotated("base_frame", child), sign))
        ).coeffs()
        decides = int(np.argmax(np.abs(product)))
        signs = _NEGATIVE if product[decides] < 0.0 else _POSITIVE
        order = self._bindings.quaternion_convention
        return rotation4(self._rotated("world_frame", child), order, signs[decides])

    def axis_angle3(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """How ``child`` is turned in ``parent``: shape ``[3]``, unit axis times angle [rad]."""
        return axis_angle3(self._rotated(parent, child), self._signs.get(child, "+w"))

    def pose7(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """Position [m] and unit quaternion of one frame: shape ``[7]``."""
        order = self._bindings.quaternion_convention
        return pose7(self._pose(parent, child), order, self._signs.get(child, "+w"))

    def planar3(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """x, y [m] and yaw about z [rad], in (-pi, pi]: shape ``[3]``."""
        pose = self._pose(parent, child)
        x, y, _ = pose.translation
        return np.array([x, y, np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0])])

    def joints(self) -> FloatArray:
        """Positions of the bound joints in their order, else of the layout's own [rad or m]."""
        return self._joints.positions(self._layout.bound_joints(self._bindings))

    def joint_velocities(self) -> FloatArray:
        """Velocities of the same joints [rad/s or m/s]."""
        names = self._layout.bound_joints(self._bindings)
        return np.array([self._joints.velocity(name) for name in names])

    def gripper2(self) -> FloatArray:
        """Both fingers [m]: two joints as measured, or one joint v as ``[v, -v]``."""
        names = self._layout.bound_gripper(self._bindings)
        return gripper_pair(names, self._joints.position)

    def gripper_velocities2(self) -> FloatArray:
        """Velocities of the same fingers [m/s]."""
        names = self._layout.bound_gripper(self._bindings)
        return gripper_pair(names, self._joints.velocity)

    def in_world(self, frame: str) -> BoundInputs:
        """The same with ``world_frame`` bound to ``frame``."""
        bindings = self._bindings.model_copy(update={"world_frame": frame})
        return BoundInputs(self._name, self._layout, bindings, self._joints, self._transforms)

    def _pose(self, parent: str, child: str) -> SE3:
        bound = self._bindings
        return self._transforms.pose(
            getattr(bound, parent) or self._refuse(parent),
            getattr(bound, child) or self._refuse(child),
        )

    def _rotated(self, parent: ParentBinding, child: PoseBinding) -> SE3:
        """As `_pose`, but the end effector's rotation may be bound to another frame."""
        has_own = child == "eef_frame" and self._bindings.eef_rotation_frame
        return self._pose(parent, "eef_rotation_frame" if has_own else child)

    def _refuse(self, binding: str) -> NoReturn:
        # Manifests without it are refused when they are loaded; this is for direct callers.
        raise LayoutError(
            f"layout {self._name}: the bindings name no {binding}",
            kind="missing_frame",
            name=binding,
        )
