"""With the composite switch up a tool turns by what is left of a row, and then by the next."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np
import pytest

from bench.soundness.arena import Arena
from bench.soundness.chunk_rows import Row
from bench.soundness.gate_loop import GateLoop
from bench.soundness.share_robot import ShareRobot
from fairlead.hal.backend import PartCommand
from fairlead.messages import Outcome
from fairlead.modes import ControlMode
from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot

START = np.array(
    [0.4309, -2.7009, -0.2798, 0.4735, 1.1009, 1.7732, -1.6898, 2.312, 3.602, -0.7701, 0.0508]
)
FIRST = np.array([0.0413, 0.0204, 0.0398, 0.3768, -0.4525, 0.0561])
THEN = np.array([-0.03, 0.0055, -0.0257, -0.2985, -0.0227, -0.0573])
"""Found by the campaign: turns about other axes, near a singular configuration."""


def rows(*motions: np.ndarray) -> Sequence[Row]:
    switch = PartCommand(ControlMode.COMPOSITE_MODE, "", np.array([1.0]), ())
    return [
        {
            "arm": PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", motion, ()),
            "composite": switch,
        }
        for motion in motions
    ]


@pytest.mark.processes
def test_turns_about_other_axes_are_followed_one_after_the_other() -> None:
    robot = load_robot("panda_mobile")
    file = json.loads(gate_config(robot.id, "sim").read_text())
    arena, model = Arena(file), ShareRobot(robot, file)
    positions = np.zeros(len(robot.measured_joint_names))
    positions[: len(START)] = START
    model.begin(positions, np.ones((4, len(robot.parts))))
    loop = GateLoop(model)
    try:
        loop.begin(0, {"arm": ("arm", "composite")})
        assert loop.propose(rows(FIRST), "arm").outcome == Outcome.RELEASED
        assert loop.advance("first") is not None
        # Added up, the turns tell 0.5 rad/s less of a joint than it gets, which then stops 56 mrad
        # beyond its bound.
        verdict = loop.propose(rows(THEN), "arm")
        assert (verdict.outcome, verdict.code) == (Outcome.REFUSED, 24), verdict
        # What the check is about: the model, which is pinocchio's, does get there.
        done = model.step("then", loop.now, rows(THEN)[0])
        assert arena.room(model.stopped(done)[None])["bounds"][0] < -0.05
    finally:
        loop.close()
