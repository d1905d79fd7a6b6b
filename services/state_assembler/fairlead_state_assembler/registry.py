"""Layouts and the functions that assemble them: the public face of this package.

Works without Zenoh, for example in a notebook::

    values = assemble_state("human300_16d", bindings, joints, buffer.at(tick))

A new layout is one name and one row in ``fairlead.skill.bindings``, and one file in
``layouts/``, named after it: a function registered here, and ``example_<layout>()``.
"""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Protocol, get_args

import numpy as np

from fairlead.errors import ConfigError, LayoutError, expected
from fairlead.messages import FloatArray
from fairlead.skill.bindings import (
    LAYOUT_DIMS,
    StateContract,
    StateContractBindings,
    StateLayout,
)
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_decoding import SE3


class Transforms(Protocol):
    """What a layout may ask of the transforms of its tick."""

    def pose(self, parent: str, child: str) -> SE3:
        """T_parent_child as a `pinocchio.SE3` [m]; raises `LayoutError`."""


Assembler = Callable[[StateContractBindings, JointPositions, Transforms], FloatArray]

LAYOUT_ASSEMBLERS: dict[str, Assembler] = {}
"""The function of every layout that can be assembled."""

LAYOUT_EXAMPLES: dict[str, Callable[[], StateContractBindings]] = {}
"""Each layout's ``example_<layout>()``: bindings to start from."""


def register(layout: StateLayout) -> Callable[[Assembler], Assembler]:
    """Decorator: make a function the assembler of ``layout``.

    Raises:
        ConfigError: if `StateLayout` has no such name, if the layout has no width, or if
            it has an assembler already.
    """

    def remember(assembler: Assembler) -> Assembler:
        if layout not in get_args(StateLayout):
            raise ConfigError(
                expected("StateLayout", "a declared layout", repr(layout), get_args(StateLayout))
            )
        if layout not in LAYOUT_DIMS:
            raise ConfigError(f"layout {layout}: fairlead.skill.bindings.LAYOUTS gives it no width")
        if layout in LAYOUT_ASSEMBLERS:
            raise ConfigError(f"layout {layout}: has an assembler already")
        LAYOUT_ASSEMBLERS[layout] = assembler
        return assembler

    return remember


def remember_example(module: ModuleType, layout: str) -> None:
    """Take ``example_<layout>`` of the module that is layout ``layout``'s file.

    Raises:
        ConfigError: if the module registers no layout of its own name, or has no example.
    """
    example = getattr(module, f"example_{layout}", None)
    if layout not in LAYOUT_ASSEMBLERS or not callable(example):
        raise ConfigError(
            f"layouts/{layout}.py: expected a function registered as {layout!r} and "
            f"example_{layout}()"
        )
    LAYOUT_EXAMPLES[layout] = example


def assemble_state(
    layout: StateLayout,
    bindings: StateContractBindings,
    joints: JointPositions,
    transforms: Transforms,
) -> FloatArray:
    """The state vector of one layout at one tick: float64, shape ``[LAYOUT_DIMS[layout]]``.

    Raises:
        LayoutError: what is missing, stale or not finite, and where; ``no_assembler``
            for a layout nobody assembles; ``wrong_width`` for an assembler whose vector is
            not as long as its layout. Never a vector with a guess in it.
    """
    assembler = LAYOUT_ASSEMBLERS.get(layout)
    if assembler is None:
        raise LayoutError(
            f"layout {layout}: no assembler (valid: {', '.join(LAYOUT_ASSEMBLERS)})",
            kind="no_assembler",
            name=layout,
        )
    values = assembler(bindings, joints, transforms)
    if values.shape != (LAYOUT_DIMS[layout],):
        raise LayoutError(
            expected(f"layout {layout}", f"{LAYOUT_DIMS[layout]} numbers", values.shape),
            kind="wrong_width",
            name=layout,
        )
    return _finite(layout, values)


def assemble_contract(
    contract: StateContract, joints: JointPositions, transforms: Transforms
) -> FloatArray:
    """The state vector of a skill at one tick, of a layout or of joints: float64, ``[dim]``.

    Raises:
        LayoutError: as `assemble_state`.
    """
    if contract.layout is not None:
        return assemble_state(contract.layout, contract.bindings, joints, transforms)
    values = [
        field.per_si * (joints.position if field.quantity == "position" else joints.velocity)(name)
        for field in contract.joints
        for name in field.names
    ]
    return _finite(contract.layout_name, np.array(values))


def _finite(layout: str, values: FloatArray) -> FloatArray:
    if not np.all(np.isfinite(values)):
        index = int(np.flatnonzero(~np.isfinite(values))[0])
        raise LayoutError(
            f"layout {layout}: index {index} is not finite: {values[index]}",
            kind="not_finite",
            name=str(index),
        )
    return values
