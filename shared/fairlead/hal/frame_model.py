"""What a robot itself says of where its frames are, beside what its description (URDF) says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from fairlead.hal.backend import FramePose
from fairlead.messages import FloatArray


class FrameModel(Protocol):
    """The robot's own model: a simulator's, or that of an arm's controller.

    The host compares it with the description before the first tick.
    """

    def frame_poses(self, positions: FloatArray | None) -> Sequence[FramePose]:
        """T_base_frame of every frame it knows under the description's name.

        Args:
            positions: of the measured joints in wire order, shape ``[n]`` [rad or m]; None: where
                the robot stands now.

        Returns:
            Poses in the robot's ``base_frame``. Nothing for positions it cannot answer for: an
            arm's controller knows its tool's pose only where the arm is.
        """
