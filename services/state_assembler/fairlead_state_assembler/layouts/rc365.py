"""rc365: the same 16 numbers as human300_16d, by the name RLDX checkpoints give them."""

from __future__ import annotations

from fairlead.messages import FloatArray
from fairlead.skill.bindings import StateContractBindings
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.layouts import human300_16d
from fairlead_state_assembler.registry import Transforms, register


@register("rc365")
def assemble(
    bindings: StateContractBindings, joints: JointPositions, transforms: Transforms
) -> FloatArray:
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
    return human300_16d.assemble(bindings, joints, transforms)


def example_rc365() -> StateContractBindings:
    """The same as for human300_16d."""
    return human300_16d.example_human300_16d()
