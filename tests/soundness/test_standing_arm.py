"""Realtime, states lost: an arm that has come by and stands is met where it stands."""

from __future__ import annotations

import json

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, Measured, PartRows
from bench.equipment.core_gate import CoreGate
from bench.soundness.arena import Arena
from fairlead.messages import Outcome
from fairlead.modes import ControlMode
from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot

ROBOT = load_robot("dual_panda")
CONFIG = gate_config(ROBOT.id, "sim")
NAMES = list(ROBOT.measured_joint_names)
LEFT = [NAMES.index(f"left_joint{i}") for i in range(1, 8)]
RIGHT = [NAMES.index(f"right_joint{i}") for i in range(1, 8)]


def positions(left: list[float], right: list[float]) -> np.ndarray:
    found = np.zeros(len(NAMES))
    found[LEFT], found[RIGHT] = left, right
    return found


STANDS = [0.342, 1.824, -2.2378, -2.4357, 2.9858, 1.982]
LEFT_ARM = [-0.2539, 0.6044, -2.1589, -2.4524, 0.4801, 3.0811, -1.3868]
CAME_FROM = positions(LEFT_ARM, [-0.7187, *STANDS])
IS_AT = positions(LEFT_ARM, [-0.7187, 0.542, *STANDS[1:]])
STEP = 0.054 * np.array([1, 1, 1, 1, 0, 0, 0])


@pytest.mark.processes
def test_an_arm_that_stands_after_lost_states_is_met_where_it_stands() -> None:
    """It came by 0.2 rad while two states were lost, and stands: its velocities say so, rightly.

    Its positions could also be those of an arm that goes on at 4 rad/s: the second row, which may
    act before the gate hears more, has to be clear of both.
    """
    arena, gate = Arena(json.loads(CONFIG.read_text())), CoreGate(CONFIG)
    still = [Measured(tick, q, np.zeros(len(q)), np.zeros(len(q))) for tick, q in
             ((1, CAME_FROM), (4, IS_AT))]  # fmt: skip
    rows = np.zeros((4, ROBOT.n_dof))
    rows[:, LEFT] = IS_AT[LEFT] + np.outer(np.arange(1, 5), STEP)
    part = PartRows(0, int(ControlMode.JOINT_POSITION), rows, "", tuple(LEFT))
    try:
        gate.start("realtime", still[0])
        gate.claim(Case(ROBOT.id, "realtime", still[0], Chunk(2, 1, ())), "x", ("left_arm",))
        gate.pass_time()
        gate.pass_time()
        assert not gate.state(still[1])
        verdict = gate.send(Chunk(5, 4, (part,)), 4, "x").verdict
    finally:
        gate.close()
    # The second row may act before the gate judges anew: it ends and the arm brakes from there.
    speed = STEP / 0.05
    slows = np.array([joint["acceleration_limit"] for joint in gate.file["joints"][:7]])
    rest = IS_AT.copy()
    rest[LEFT] = rows[1, LEFT] + speed * np.abs(speed) / (2.0 * slows)
    assert arena.room(rest[None])["self-collision"][0] < -0.05
    released = verdict.released_last - verdict.released_first + 1
    assert verdict.outcome == Outcome.REFUSED or released < 2, (verdict.outcome, released)
