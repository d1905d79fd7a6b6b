"""mobile_pick_30d: human300_16d, then the object and the goal in the base."""

from __future__ import annotations

import numpy as np

from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings
from fairlead_state_assembler.bound_frames import BoundFrames
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.layouts import human300_16d
from fairlead_state_assembler.registry import Transforms, register


@register("mobile_pick_30d")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
    """Assemble the vector: float64, shape ``[30]``.

    ======== ====================== ====== ==============================================
    slice    content                unit   source
    ======== ====================== ====== ==============================================
    [0:16]   robot                  --     as in ``human300_16d``
    [16:19]  object's position      m      ``object_frame`` in ``base_frame``
    [19:23]  object's rotation      quat.  ``object_frame`` in ``base_frame``
    [23:26]  goal's position        m      ``goal_frame`` in ``base_frame``
    [26:30]  goal's rotation        quat.  ``goal_frame`` in ``base_frame``
    ======== ====================== ====== ==============================================

    Raises:
        LayoutError: for a frame or joint that is missing or too old.
    """
    at = BoundFrames("mobile_pick_30d", bindings, transforms)
    return np.concatenate(
        (
            human300_16d.assemble(bindings, joints, transforms),
            at.pose7("base_frame", "object_frame"),
            at.pose7("base_frame", "goal_frame"),
        )
    )


def example_mobile_pick_30d() -> StateContractBindings:
    """The frames of human300_16d, two that a fiducial tracker publishes, and odometry's own.

    The base is driven by this vector, and is commanded along odom's axes.
    """
    return human300_16d.example_human300_16d().model_copy(
        update={"object_frame": "object", "goal_frame": "goal", "world_frame": "odom"}
    )
