"""What interpolation changes for a simulated drive of 500 Hz that follows rows of 20 Hz.

Panda's arm in MuJoCo goes to and fro at the largest steps that its gate admits, without a gate.

    .venv/bin/python -m bench.interpolation [--json]

Prints, of setpoints made each way: the largest leap of their velocity from one drive step to the
next, and of the simulated arm the largest joint acceleration, the largest change of a torque in a
drive step, and how far joints are behind their rows at most.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass
from typing import get_args

import mujoco
import numpy as np

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.interpolation import Interpolation
from fairlead.robot.manifest import load_robot
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend

ARM = tuple(range(7))
DRIVE_S = 0.002
ROWS = 200


@dataclass(frozen=True)
class Driven:
    """The largest of each over all joints and drive steps."""

    setpoint_leap_rad_s: float
    acceleration_rad_s2: float
    torque_change_nm: float
    lag_rad: float


def rows(start: FloatArray) -> FloatArray:
    """Each joint to and fro by up to 0.055 rad a row, at a rate of its own; ``[ROWS, 7]``."""
    phases = np.arange(ROWS)[:, None] * np.linspace(0.1, 0.3, len(ARM))
    return start + np.cumsum(0.055 * np.sin(phases), axis=0)


def drive(interpolation: Interpolation) -> Driven:
    """Carry the rows out with a drive that is told a setpoint each 2 ms."""
    backend = MujocoBackend(load_robot("panda").model_copy(update={"interpolation": interpolation}))
    seen: list[tuple[FloatArray, FloatArray, FloatArray]] = []

    def look(_model: mujoco.MjModel, data: mujoco.MjData) -> None:
        parts = (data.ctrl, data.qvel, data.qfrc_actuator)
        seen.append((parts[0][:7].copy(), parts[1][:7].copy(), parts[2][:7].copy()))

    lag = 0.0
    mujoco.set_mjcb_control(look)
    try:
        for row in rows(backend.read().positions[: len(ARM)]):
            command = PartCommand(ControlMode.JOINT_POSITION, "", np.append(row, 0.0), ARM)
            backend.apply({"arm": command})
            lag = max(lag, float(np.abs(backend.read().positions[: len(ARM)] - row).max()))
    finally:
        mujoco.set_mjcb_control(None)
    setpoints, velocities, torques = (np.array(column) for column in zip(*seen, strict=True))
    return Driven(
        float(np.abs(np.diff(setpoints, 2, axis=0)).max() / DRIVE_S),
        float(np.abs(np.diff(velocities, axis=0)).max() / DRIVE_S),
        float(np.abs(np.diff(torques, axis=0)).max()),
        lag,
    )


def table(found: dict[Interpolation, Driven]) -> str:
    """Markdown, one line each way."""
    lines = [
        "| interpolation | leap of setpoints rad/s | acceleration rad/s² | torque change N m "
        "| lag rad |",
        "|---|---|---|---|---|",
    ]
    for name, one in found.items():
        values = (
            one.setpoint_leap_rad_s,
            one.acceleration_rad_s2,
            one.torque_change_nm,
            one.lag_rad,
        )
        lines.append(f"| `{name}` | {' | '.join(f'{value:.2f}' for value in values)} |")
    return "\n".join(lines)


def main() -> None:
    """Drive both ways and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    arguments = parser.parse_args()
    found = {name: drive(name) for name in get_args(Interpolation)}
    if arguments.json:
        print(json.dumps({name: asdict(one) for name, one in found.items()}))
        return
    print(table(found))


if __name__ == "__main__":
    main()
