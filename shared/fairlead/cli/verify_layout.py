"""Compare a skill's layout with simulator truth while the robot is driven at random.

The simulator, the layout and the bindings run in this process, through the same pure
functions as in the services.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fairlead.bindings import StateContract
from fairlead.cli.layout_truth import LAYOUT_FIELDS, Field, Truth, field_error, read_truth
from fairlead.errors import LayoutError
from fairlead.hal.backend import FramePose, PartCommand
from fairlead.messages import FloatArray, HalPart, floats
from fairlead.modes import ControlMode
from fairlead.robot import RobotManifest, load_robot
from fairlead.skill import SkillManifest

if TYPE_CHECKING:
    from fairlead_state_assembler import LocalAssembler

ALLOWED = {"position": 1e-4, "rotation": 1e-4, "gripper": 1e-3}
"""Largest error per kind of field: [m], [rad], [m]."""

KEEP_COMMAND_TICKS = 10
"""Random commands are kept this long, so that the robot gets somewhere."""


@dataclass(frozen=True)
class FieldReport:
    """One field's result.

    Attributes:
        worst: largest error seen [m or rad].
        at_tick: when it was seen.
        binding: what is off, and which frame would fit if one does; "" if it agrees.
    """

    field: str
    unit: str
    worst: float
    allowed: float
    at_tick: int
    binding: str

    @property
    def ok(self) -> bool:
        return self.worst <= self.allowed


@dataclass(frozen=True)
class _Sample:
    positions: FloatArray
    transforms: tuple[FramePose, ...]
    static: tuple[FramePose, ...]
    truth: Truth


def verify_layout(
    skill: SkillManifest, n_ticks: int = 200, seed: int = 0, robot_id: str | None = None
) -> list[FieldReport]:
    """Drive at random for ``n_ticks`` and report every field of the skill's layout.

    Args:
        robot_id: the robot to bind to; None for the skill's first embodiment.

    Raises:
        LayoutError: if a bound frame or joint does not exist.
        ConfigError: if the robot or its simulator cannot be loaded.
    """
    from fairlead_hal_sim.options import SimulatorOptions
    from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
    from fairlead_state_assembler import LocalAssembler

    robot = load_robot(robot_id or skill.embodiments[0])
    contract = skill.state_contract
    backend = RobosuiteBackend(SimulatorOptions(seed=seed), robot.tick_period_ns)
    assembler, rng = LocalAssembler(robot), np.random.default_rng(seed)
    worst = {field.name: (-1.0, 0) for field in LAYOUT_FIELDS[contract.layout]}
    try:
        for tick in range(1, n_ticks + 1):
            sample = _Sample(
                backend.read().positions,
                tuple(backend.transforms()),
                tuple(backend.static_transforms()),
                read_truth(backend.env),
            )
            for name, error in _errors(assembler, contract, sample).items():
                if error > worst[name][0]:
                    worst[name] = (error, tick)
            if tick % KEEP_COMMAND_TICKS == 1:
                commands = _random_commands(rng, robot, backend.describe().parts)
            backend.apply(commands)
    finally:
        backend.close()
    return [
        _report(assembler, contract, field, *worst[field.name], sample)
        for field in LAYOUT_FIELDS[contract.layout]
    ]


def _errors(
    assembler: LocalAssembler, contract: StateContract, sample: _Sample
) -> Mapping[str, float]:
    assembler.take(sample.positions, sample.transforms, sample.static)
    values = assembler.assemble(contract)
    order = contract.bindings.quaternion_convention
    return {
        field.name: field_error(field, order, values, sample.truth)
        for field in LAYOUT_FIELDS[contract.layout]
    }


def _random_commands(
    rng: np.random.Generator, robot: RobotManifest, parts: tuple[HalPart, ...]
) -> dict[str, PartCommand]:
    """Each part in its first mode, anywhere in its declared range."""
    commands = {}
    for part in parts:
        mode = ControlMode(part.ranges[0].mode)
        row = rng.uniform(floats(part.ranges[0].lower), floats(part.ranges[0].upper))
        active: tuple[int, ...] = ()
        if mode.is_joint_mode:
            active = tuple(robot.joint_names.index(name) for name in part.joints)
            values = np.zeros(robot.n_dof)
            values[list(active)] = row
            row = values
        frame = robot.base_frame if mode is ControlMode.CARTESIAN_DELTA else ""
        commands[part.name] = PartCommand(mode, frame, row, active)
    return commands


def _report(
    assembler: LocalAssembler,
    contract: StateContract,
    field: Field,
    worst: float,
    tick: int,
    sample: _Sample,
) -> FieldReport:
    allowed = ALLOWED[field.kind]
    unit = "rad" if field.kind == "rotation" else "m"
    blame = "" if worst <= allowed else _blame(assembler, contract, field, sample)
    return FieldReport(field.name, unit, worst, allowed, tick, blame)


def _blame(
    assembler: LocalAssembler, contract: StateContract, field: Field, sample: _Sample
) -> str:
    """The bindings behind a field that is off, and every frame that would make it right."""
    parts, fits = [], []
    for binding in field.bindings:
        bound = getattr(contract.bindings, binding) or contract.bindings.eef_frame
        parts.append(f"{binding}: {bound}")
        if binding == "gripper_qpos_joints":
            continue
        for frame in sorted(assembler.frames):
            changed = contract.bindings.model_copy(update={binding: frame})
            other = contract.model_copy(update={"bindings": changed})
            try:
                error = _errors(assembler, other, sample)[field.name]
            except LayoutError:
                continue
            if error <= ALLOWED[field.kind]:
                fits.append(f"{binding}: {frame}")
    off = " or ".join(parts)
    return f"{off} is off" + (f"; would agree: {', '.join(fits)}" if fits else "")
