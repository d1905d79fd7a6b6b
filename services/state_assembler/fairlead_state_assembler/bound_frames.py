"""Poses between the frames that a skill's bindings name."""

from __future__ import annotations

from typing import Literal

import numpy as np

from fairlead.errors import LayoutError
from fairlead.messages import FloatArray
from fairlead.skill.bindings import (
    PoseBinding,
    QuaternionSign,
    StateContractBindings,
    StateLayout,
)
from fairlead_state_assembler.pose_decoding import SE3
from fairlead_state_assembler.pose_vector import axis_angle3, rotation4
from fairlead_state_assembler.registry import Transforms

ParentBinding = Literal["base_frame", "world_frame"]


class BoundFrames:
    """Reads poses by the names of bindings; order and sign are those bound.

    Every method raises `LayoutError` for a binding that names no frame, and for a frame
    that is missing or too old.
    """

    def __init__(
        self, layout: StateLayout, bindings: StateContractBindings, transforms: Transforms
    ) -> None:
        self._layout = layout
        self._bindings = bindings
        self._transforms = transforms

    def position3(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """Where ``child`` is in ``parent``: shape ``[3]`` [m]."""
        return np.array(self._pose(parent, child).translation)

    def quaternion4(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """How ``child`` is turned in ``parent``: shape ``[4]``, unit quaternion."""
        return self._quaternion(self._rotated(parent, child), child)

    def axis_angle3(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """How ``child`` is turned in ``parent``: shape ``[3]``, unit axis times angle [rad]."""
        return axis_angle3(self._rotated(parent, child), self._sign(child))

    def pose7(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """Position [m] and unit quaternion of one frame: shape ``[7]``."""
        pose = self._pose(parent, child)
        return np.concatenate((pose.translation, self._quaternion(pose, child)))

    def planar3(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """x, y [m] and yaw about z [rad], in (-pi, pi]: shape ``[3]``."""
        pose = self._pose(parent, child)
        x, y, _ = pose.translation
        return np.array([x, y, np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0])])

    def _quaternion(self, pose: SE3, child: PoseBinding) -> FloatArray:
        return rotation4(pose, self._bindings.quaternion_convention, self._sign(child))

    def _sign(self, child: PoseBinding) -> QuaternionSign:
        return self._bindings.quaternion_signs.get(child, "+w")

    def _pose(self, parent: ParentBinding, child: PoseBinding) -> SE3:
        return self._transforms.pose(self._frame(parent), self._frame(child))

    def _rotated(self, parent: ParentBinding, child: PoseBinding) -> SE3:
        """As `_pose`, but the end effector's rotation may be bound to another frame."""
        other = self._bindings.eef_rotation_frame
        if child == "eef_frame" and other is not None:
            return self._transforms.pose(self._frame(parent), other)
        return self._pose(parent, child)

    def _frame(self, binding: str) -> str:
        # Manifests without it are refused when they are loaded; this is for direct callers.
        frame = getattr(self._bindings, binding)
        if not isinstance(frame, str) or not frame:
            raise LayoutError(
                f"layout {self._layout}: the bindings name no {binding}",
                kind="missing_frame",
                name=binding,
            )
        return frame
