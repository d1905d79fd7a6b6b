"""base_pose_6d: where a mobile base stands, in the world and in odom (planners)."""

from __future__ import annotations

import numpy as np

from fairlead.frames import MAP, ODOM
from fairlead.layout import Layout, LayoutInputs
from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings


def assemble(at: LayoutInputs) -> FloatArray:
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
    in_odom = at.in_world(ODOM)
    return np.concatenate(
        (at.planar3("world_frame", "base_frame"), in_odom.planar3("world_frame", "base_frame"))
    )


LAYOUT = Layout(
    content="where a mobile base stands, in the world and in odom (planners)",
    dim=6,
    assemble=assemble,
    required=("base_frame", "world_frame"),
    example=StateContractBindings(base_frame="base_link", world_frame=MAP),
)
"""The example: a base whose link is base_link, in the localiser's map."""
