"""Compare a state vector with simulator truth while the robot is driven at random.

The simulator, the layout and the bindings run in this process, through the same pure
functions as in the services.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fairlead.deploy.service_options import check_options
from fairlead.deploy.shipped_deployments import shipped_deployments
from fairlead.errors import ConfigError, LayoutError
from fairlead.hal.backend import FramePose, PartCommand
from fairlead.layout import LayoutField, load_layout
from fairlead.messages import FloatArray, HalPart, floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.state_contract import StateContract
from fairlead_tools.parity.layout_truth import (
    Truth,
    field_error,
    read_truth,
    sign_differs,
    verifiable_fields,
)

if TYPE_CHECKING:
    from fairlead_hal_sim import SimulatorOptions
    from fairlead_state_assembler import LocalAssembler


ALLOWED = {
    "position": 1e-4,
    "quaternion": 1e-4,
    "axis-angle": 1e-4,
    "gripper": 1e-3,
    "gripper velocities": 1e-3,
    "joints": 1e-4,
    "joint velocities": 1e-4,
    "ratios": 1e-4,
}
"""Largest error per kind of field, in its unit."""

UNITS = {
    "position": "m",
    "quaternion": "rad",
    "axis-angle": "rad",
    "gripper": "m",
    "gripper velocities": "m/s",
    "joints": "rad",
    "joint velocities": "rad/s",
    "ratios": "",
}

OUR_SCENE = "MobilePickPlace"
BASE_LOWEST, BASE_HIGHEST = (-3.0, -3.0, -3.0), (-2.0, -2.0, 3.0)
"""Where the robot is put [m, m, rad]: where nothing else stands."""

KEEP_COMMAND_TICKS = 10
"""Random commands are kept this long, so that the robot gets somewhere."""


@dataclass(frozen=True)
class FieldReport:
    """One field's result.

    Attributes:
        worst: largest error seen [m or rad].
        at_tick: when it was seen.
        binding: what is off, and which frame would fit if one does; "" if it agrees.
        other_sign_ticks: ticks in which the simulator's quaternion had the opposite sign:
            the same rotation, but other numbers (see ``quaternion_signs``).
    """

    field: str
    unit: str
    worst: float
    allowed: float
    at_tick: int
    binding: str
    other_sign_ticks: int

    @property
    def ok(self) -> bool:
        """Whether the worst difference is allowed."""
        return self.worst <= self.allowed


@dataclass(frozen=True)
class _Sample:
    positions: FloatArray
    velocities: FloatArray
    transforms: tuple[FramePose, ...]
    static: tuple[FramePose, ...]
    truth: Truth


class _Worst:
    """The largest error of one field so far."""

    def __init__(self) -> None:
        self.error = -1.0
        self.tick = 0
        self.other_sign_ticks = 0

    def add(self, tick: int, error: float, *, other_sign: bool) -> None:
        self.other_sign_ticks += other_sign
        if error > self.error:
            self.error, self.tick = error, tick


def verify_layout(
    contract: StateContract, robot_id: str, n_ticks: int = 200, seed: int = 0
) -> list[FieldReport]:
    """Drive ``robot_id`` at random for ``n_ticks`` and report every field of the layout.

    In our own scene the seed also puts the robot's base somewhere in the simulator's world,
    turned anyhow: where it stands at the origin, a wrong ``world_frame`` cannot be seen.

    Raises:
        LayoutError: if a bound frame or joint does not exist, or nothing assembles the
            layout.
        ConfigError: if the simulator has no truth for the layout, or the robot or its
            simulator cannot be loaded, or no deployment simulates it in robosuite.
    """
    from fairlead_hal_sim import RobosuiteBackend
    from fairlead_state_assembler import LocalAssembler

    robot = load_robot(robot_id)
    if contract.layout is None:
        raise ConfigError(
            "layout verify: expected a layout, got joints: they are what the robot measures, and "
            "there is nothing to compare"
        )
    fields = verifiable_fields(contract.layout)
    order = contract.bindings.quaternion_convention
    assembler, rng = LocalAssembler(robot), np.random.default_rng(seed)
    base_pose = rng.uniform(BASE_LOWEST, BASE_HIGHEST).tolist()
    options = _simulator(robot_id, base_pose).model_copy(update={"seed": seed, "cameras": ()})
    backend = RobosuiteBackend(options, robot.tick_period_ns, robot)
    worst = {field: _Worst() for field in fields}
    try:
        for tick in range(1, n_ticks + 1):
            sample = _Sample(
                backend.read().positions,
                backend.read().velocities,
                tuple(backend.transforms()),
                tuple(backend.static_transforms()),
                read_truth(backend.env, fields),
            )
            values = _values(assembler, contract, sample)
            for field, so_far in worst.items():
                error = field_error(field, order, values, sample.truth)
                other = sign_differs(field, order, values, sample.truth)
                so_far.add(tick, error, other_sign=other)
            if tick % KEEP_COMMAND_TICKS == 1:
                commands = _random_commands(rng, robot, backend.describe().parts)
            backend.apply(commands)
    finally:
        backend.close()
    return [_report(assembler, contract, field, worst[field], sample) for field in fields]


def _simulator(robot: str, base_pose: list[float]) -> SimulatorOptions:
    """How the robot's first deployment with robosuite simulates it."""
    from fairlead_hal_sim import HalSimOptions

    for _, deployment in shipped_deployments(robot):
        hal = deployment.services[deployment.hal]
        if hal.run == "hal_sim":
            options = check_options(deployment, deployment.hal, HalSimOptions)
            place = {"base_pose": base_pose} if options.env == OUR_SCENE else {}
            return options.model_copy(update={"env_options": options.env_options | place})
    raise ConfigError(
        f"layout verify: robot {robot}: no deployment in compose/ simulates it in robosuite "
        "(run: hal_sim), whose observations are the truth to compare with"
    )


def _values(assembler: LocalAssembler, contract: StateContract, sample: _Sample) -> FloatArray:
    assembler.take(sample.positions, sample.transforms, sample.static, sample.velocities)
    return assembler.assemble(contract)


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
    field: LayoutField,
    worst: _Worst,
    sample: _Sample,
) -> FieldReport:
    allowed = ALLOWED[field.kind]
    unit = UNITS[field.kind]
    blame = "" if worst.error <= allowed else _blame(assembler, contract, field, sample)
    return FieldReport(
        field.name, unit, worst.error, allowed, worst.tick, blame, worst.other_sign_ticks
    )


def _blame(
    assembler: LocalAssembler, contract: StateContract, field: LayoutField, sample: _Sample
) -> str:
    """The bindings behind a field that is off, and every frame that would make it right."""
    order = contract.bindings.quaternion_convention
    parts, fits = [], []
    for binding in field.bindings:
        parts.append(f"{binding}: {_bound_to(contract, binding)}")
        if not binding.endswith("_frame"):
            continue
        for frame in sorted(assembler.frames):
            changed = contract.bindings.model_copy(update={binding: frame})
            other = contract.model_copy(update={"bindings": changed})
            try:
                values = _values(assembler, other, sample)
            except LayoutError:
                continue
            if field_error(field, order, values, sample.truth) <= ALLOWED[field.kind]:
                fits.append(f"{binding}: {frame}")
    off = " or ".join(parts)
    return f"{off} is off" + (f"; would agree: {', '.join(fits)}" if fits else "")


def _bound_to(contract: StateContract, binding: str) -> object:
    bindings = contract.bindings
    if contract.layout and binding == "joint_names":
        return load_layout(contract.layout).bound_joints(bindings)
    if contract.layout and binding == "gripper_qpos_joints":
        return load_layout(contract.layout).bound_gripper(bindings)
    return getattr(bindings, binding) or bindings.eef_frame
