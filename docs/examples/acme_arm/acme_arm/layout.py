"""acme_tip_5d: the tip in the base, then both joints."""

from __future__ import annotations

import numpy as np

from fairlead import StateContractBindings
from fairlead.layout import Layout, LayoutInputs
from fairlead.messages import FloatArray


def assemble(at: LayoutInputs) -> FloatArray:
    """Assemble the vector: float64, shape ``[5]``.

    ======== =============== ====== ======================================================
    slice    content         unit   source
    ======== =============== ====== ======================================================
    [0:3]    tip's position  m      ``eef_frame`` in ``base_frame``
    [3:5]    joints          rad    ``joint_names``; unbound: ``acme_pan``, ``acme_lift``
    ======== =============== ====== ======================================================
    """
    return np.concatenate((at.position3("base_frame", "eef_frame"), at.joints()))


LAYOUT = Layout(
    content="the tip in the base, both joints",
    dim=5,
    assemble=assemble,
    required=("eef_frame", "base_frame"),
    joint_names=("acme_pan", "acme_lift"),
    example=StateContractBindings(eef_frame="acme_tip", base_frame="base_link"),
)
