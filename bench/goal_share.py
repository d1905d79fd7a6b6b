"""Which share of the way to its goal a tool goes in a tick, with the composite switch up.

    .venv/bin/python -m bench.goal_share

The mobile robot's simulator without a gate. Each axis alone, gently: rows that go on alike, then
zeros. With the switch up its controller adds each row to its last goal; the gate reckons with
`gain` of what is left to that (docs/safety-checks.md, composite switch up). Prints the smallest and
the largest share in the first tick, where the rows go on, and while the tool comes to rest.
"""

from __future__ import annotations

import argparse

import numpy as np

from bench.equipment.kinematics import Pose
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead_tools.measure.driven_robot import DrivenRobot

SCALE = np.array([0.01, 0.01, 0.01, 0.05, 0.05, 0.05])
"""Of a row along one axis [m, rad]."""
GOING, RESTING = 12, 4
UP = PartCommand(ControlMode.COMPOSITE_MODE, "", np.array([1.0]), ())


def shares(driven: DrivenRobot, axis: int) -> list[float]:
    """Tick by tick."""
    now, goal, found = driven.reset(axis), 0.0, []
    told = np.zeros(6)
    start = now.tools["arm"]
    for count in range(GOING + RESTING):
        told[axis] = SCALE[axis] if count < GOING else 0.0
        before = _way(start, now.tools["arm"])[axis]
        goal += told[axis]
        arm = PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", told.copy(), ())
        now = driven.step("goal", now, {"arm": arm, "composite": UP}).after
        found.append(float((_way(start, now.tools["arm"])[axis] - before) / (goal - before)))
    return found


def _way(start: Pose, now: Pose) -> FloatArray:
    """From one pose to another along the root's axes [m, rad]; turns are small ones."""
    (was_at, was_turned), (is_at, is_turned) = start, now
    turn = is_turned @ was_turned.T
    across = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return np.concatenate([is_at - was_at, np.arcsin(across / 2.0)])


def main() -> None:
    """Measure and print."""
    argparse.ArgumentParser(
        prog="python -m bench.goal_share",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    ).parse_args()
    driven = DrivenRobot("panda_mobile")
    every = np.array([shares(driven, axis) for axis in range(6)])
    for what, columns in (
        ("first tick", every[:, :1]),
        ("going on", every[:, 8:GOING]),
        ("coming to rest", every[:, GOING:]),
    ):
        print(f"{what}: {columns.min():.2f} to {columns.max():.2f}")


if __name__ == "__main__":
    main()
