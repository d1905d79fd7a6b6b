"""The state vector of a layout, or of joints, at one tick.

Works without Zenoh, for example in a notebook::

    values = assemble_state("human300_16d", bindings, joints, buffer.at(tick))
"""

from __future__ import annotations

import math

import numpy as np

from fairlead.errors import LayoutError, expected
from fairlead.layout import load_layout
from fairlead.messages import FloatArray
from fairlead.reason_text import reason_of
from fairlead.skill.bindings import StateContractBindings
from fairlead.skill.state_contract import StateContract
from fairlead_state_assembler.bound_inputs import BoundInputs, Transforms
from fairlead_state_assembler.joint_positions import JointPositions


def assemble_state(
    name: str,
    bindings: StateContractBindings,
    joints: JointPositions,
    transforms: Transforms,
) -> FloatArray:
    """The state vector of one layout at one tick: float64, as wide as the layout says.

    Raises:
        ConfigError: no installed package has a layout of this name, or it does not load.
        LayoutError: what is missing, stale or not finite, and where; ``no_assembler``
            for a layout nobody assembles; ``wrong_width`` for a function whose vector is
            not as long as its layout says, ``failed`` for one that raises anything else.
            Never a vector with a guess in it.
    """
    layout = load_layout(name)
    if layout.assemble is None:
        text = f"layout {name}: no assembler; those that have one: fairlead layout ls"
        raise LayoutError(text, kind="no_assembler", name=name)
    inputs = BoundInputs(name, layout, bindings, joints, transforms)
    try:
        values = np.asarray(layout.assemble(inputs), dtype=np.float64)
    except LayoutError:
        raise
    except Exception as error:
        text = f"layout {name}: its function failed: {reason_of(error)}"
        raise LayoutError(text, kind="failed", name=name) from error
    if values.shape != (layout.dim,):
        raise LayoutError(
            expected(f"layout {name}", f"{layout.dim} numbers", values.shape),
            kind="wrong_width",
            name=name,
        )
    return _finite(name, values)


def assemble_contract(
    contract: StateContract, joints: JointPositions, transforms: Transforms
) -> FloatArray:
    """The state vector of a skill at one tick, of a layout or of joints: float64, ``[dim]``.

    Raises:
        LayoutError: as `assemble_state`.
    """
    if contract.layout is not None:
        return assemble_state(contract.layout, contract.bindings, joints, transforms)
    values: list[float] = []
    for field in contract.joints:
        read = joints.position if field.quantity == "position" else joints.velocity
        values += field.numbers([read(name) for name in field.names])
    return _finite(contract.layout_name, np.array(values))


def _finite(layout: str, values: FloatArray) -> FloatArray:
    # The sum alone is faster to look at, and finite only if all are.
    if not math.isfinite(sum(values.tolist())) and not np.isfinite(values).all():
        index = int(np.flatnonzero(~np.isfinite(values))[0])
        raise LayoutError(
            f"layout {layout}: index {index} is not finite: {values[index]}",
            kind="not_finite",
            name=str(index),
        )
    return values
