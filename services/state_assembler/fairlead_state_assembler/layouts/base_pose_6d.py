"""base_pose_6d: where a mobile base stands, in the world and in odom (planners)."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings
from fairlead_state_assembler.bound_frames import BoundFrames
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.registry import Transforms, register


@register("base_pose_6d")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
    """Assemble the vector: float64, shape ``[6]``.

    ======== ====================== ====== ==============================================
    slice    content                unit   source
    ======== ====================== ====== ==============================================
    [0:2]    base's x and y         m      ``base_frame`` in ``world_frame``: for goals
    [2]      base's yaw             rad    the same
    [3:5]    base's x and y         m      ``base_frame`` in ``odom``: for the gate's zones
    [5]      base's yaw             rad    the same
    ======== ====================== ====== ==============================================

    Yaw is in (-pi, pi], about z.

    Raises:
        LayoutError: for a frame that is missing or too old.
    """
    at = BoundFrames("base_pose_6d", bindings, transforms)
    in_odom = BoundFrames(
        "base_pose_6d", bindings.model_copy(update={"world_frame": "odom"}), transforms
    )
    return np.concatenate(
        (at.planar3("world_frame", "base_frame"), in_odom.planar3("world_frame", "base_frame"))
    )


def example_base_pose_6d() -> StateContractBindings:
    """A base whose link is base_link, in the localiser's map."""
    return StateContractBindings(base_frame="base_link", world_frame="map")
