"""mobile_pick_30d: human300_16d, then the object and the goal in the base."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fairlead.frames import ODOM
from fairlead.layout import Layout, LayoutField, LayoutInputs
from fairlead.layouts import human300_16d
from fairlead.messages import FloatArray


def assemble(at: LayoutInputs) -> FloatArray:
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
    return np.concatenate(
        (
            human300_16d.assemble(at),
            at.pose7("base_frame", "object_frame"),
            at.pose7("base_frame", "goal_frame"),
        )
    )


_ROBOT = human300_16d.LAYOUT
_ODOM_FIELDS = tuple(
    replace(field, name=field.name.replace("world_to_base", "odom_to_base"))
    for field in _ROBOT.fields
)

LAYOUT = Layout(
    content="human300_16d, then the object and the goal in the base",
    dim=30,
    assemble=assemble,
    required=(*_ROBOT.required, "object_frame", "goal_frame"),
    optional=_ROBOT.optional,
    example=_ROBOT.example.model_copy(
        update={"object_frame": "object", "goal_frame": "goal", "world_frame": ODOM}
    ),
    fields=(
        *_ODOM_FIELDS,
        LayoutField("base_to_object position", "position", 16, ("object_frame", "base_frame")),
        LayoutField("base_to_object rotation", "quaternion", 19, ("object_frame", "base_frame")),
        LayoutField("base_to_goal position", "position", 23, ("goal_frame", "base_frame")),
        LayoutField("base_to_goal rotation", "quaternion", 26, ("goal_frame", "base_frame")),
    ),
)
"""The example: human300_16d's frames, two that a fiducial tracker publishes, and odometry's own.

The base is driven by this vector, and is commanded along odom's axes.
"""
