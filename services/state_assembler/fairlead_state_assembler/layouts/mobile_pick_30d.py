"""mobile_pick_30d: human300_16d, then the object and the goal in the base (30 numbers)."""

from __future__ import annotations

import numpy as np

from fairlead.bindings import StateContractBindings
from fairlead.messages import FloatArray
from fairlead_state_assembler.binding_check import bound
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.layouts import human300_16d
from fairlead_state_assembler.pose_vector import pose7
from fairlead_state_assembler.registry import Transforms, register


@register("mobile_pick_30d")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
    """Assemble the vector: float64, shape ``[30]``.

    ======== ============================ ====== ===========================================
    slice    content                      unit   source
    ======== ============================ ====== ===========================================
    [0:16]   robot                        --     as in human300_16d
    [16:19]  object's position            m      ``object_frame`` in ``base_frame``
    [19:23]  object's rotation            quat.  ``object_frame`` in ``base_frame``
    [23:26]  goal's position              m      ``goal_frame`` in ``base_frame``
    [26:30]  goal's rotation              quat.  ``goal_frame`` in ``base_frame``
    ======== ============================ ====== ===========================================

    Quaternions are in ``quaternion_convention`` order with w >= 0.

    Raises:
        LayoutError: for a frame or joint that is missing or too old.
    """
    base = bound("mobile_pick_30d", bindings, "base_frame")
    order = bindings.quaternion_convention
    return np.concatenate(
        (
            human300_16d.assemble(bindings, joints, transforms),
            pose7(transforms.pose(base, bound("mobile_pick_30d", bindings, "object_frame")), order),
            pose7(transforms.pose(base, bound("mobile_pick_30d", bindings, "goal_frame")), order),
        )
    )
