"""rc365: the same 16 numbers as human300_16d, by the name RLDX checkpoints give them."""

from __future__ import annotations

from dataclasses import replace

from fairlead.layout import LayoutInputs
from fairlead.layouts import human300_16d
from fairlead.messages import FloatArray


def assemble(at: LayoutInputs) -> FloatArray:
    """Assemble the vector: float64, shape ``[16]``.

    ======== ============================ ====== ==========================================
    slice    content                      unit   source
    ======== ============================ ====== ==========================================
    [0:16]   end effector, base, fingers  m,     as in ``human300_16d``, bit for bit
                                          quat.
    ======== ============================ ====== ==========================================

    A network that wants the fingers before the base re-orders them in its policy backend.

    Raises:
        LayoutError: for a frame or joint that is missing or too old.
    """
    return human300_16d.assemble(at)


LAYOUT = replace(
    human300_16d.LAYOUT,
    assemble=assemble,
    content="the same 16 numbers as human300_16d, by the name RLDX checkpoints give them",
)
