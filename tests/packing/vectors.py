"""Action maps of PandaOmron in both part orders, written down by hand."""

from __future__ import annotations

import numpy as np

from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead_hal_sim.packing import ActionMap, PartSlot

JOINTS = (
    "base_x",
    "base_y",
    "base_yaw",
    *(f"panda_joint{i}" for i in range(1, 8)),
    "panda_gripper",
)

STOCK = {"right": (0, 6), "torso": (6, 7), "base": (7, 10), "right_gripper": (10, 11)}
RECORDS = {"right": (0, 6), "right_gripper": (6, 7), "base": (7, 10), "torso": (10, 11)}
ORDERS = {"stock": STOCK, "records": RECORDS}

ARM_SCALE = np.array([0.05, 0.05, 0.05, 0.5, 0.5, 0.5])
BASE_SCALE = np.array([1.0, 1.0, 1.5])


def action_map(order: dict[str, tuple[int, int]]) -> ActionMap:
    """Twelve inputs: the order's eleven and the composite switch."""

    def slot(name: str, part: str, modes: tuple[ControlMode, ...], **rest: object) -> PartSlot:
        first, stop = order[part]
        defaults: dict[str, object] = {"offset": np.zeros(stop - first), "hold": 0.0}
        return PartSlot(name, part, first, stop, modes, **{**defaults, **rest})  # type: ignore[arg-type]

    arm = slot("arm", "right", (ControlMode.CARTESIAN_DELTA,), scale=ARM_SCALE, frame="base_link")
    gripper = slot(
        "gripper",
        "right_gripper",
        (ControlMode.GRIPPER_POSITION,),
        scale=np.array([-0.04]),
        offset=np.array([0.04]),
        hold=None,
    )
    base = slot(
        "base",
        "base",
        (ControlMode.JOINT_VELOCITY, ControlMode.BODY_TWIST),
        scale=BASE_SCALE,
        joints=(0, 1, 2),
        frame="base_link",
    )
    composite = PartSlot(
        "composite",
        "",
        11,
        12,
        (ControlMode.COMPOSITE_MODE,),
        np.array([1.0]),
        np.array([0.0]),
        -1.0,
    )
    return ActionMap(12, (arm, gripper, base, composite), JOINTS)


def delta(values: object) -> PartCommand:
    """An arm delta, SI."""
    return PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", np.asarray(values, float), ())


def opening(metres: float) -> PartCommand:
    """A gripper opening [m]."""
    return PartCommand(ControlMode.GRIPPER_POSITION, "", np.array([metres]), ())


def base_velocity(**rates: float) -> PartCommand:
    """Base joint rates by joint name; only the named joints are active."""
    values = np.zeros(len(JOINTS))
    active = tuple(sorted(JOINTS.index(name) for name in rates))
    for name, rate in rates.items():
        values[JOINTS.index(name)] = rate
    return PartCommand(ControlMode.JOINT_VELOCITY, "", values, active)


def mode(value: float) -> PartCommand:
    """The composite switch."""
    return PartCommand(ControlMode.COMPOSITE_MODE, "", np.array([value]), ())
