"""What an expert without memory makes of one state."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.policy import Observation
from fairlead_skill_runner.policies.oracle.phases import Phase
from fairlead_skill_runner.policies.oracle.policy import OraclePolicy
from tests.learn.drawn import quaternion

OPEN, SHUT = 0.08, 0.06
COUNTER, GOAL = (0.95, 0.1), (0.0, 1.9, np.pi / 2)
AT_COUNTER, STAGED, PLACING = (0.40, 0.1, 0.0), (0.0, 0.95, np.pi / 2), (0.0, 1.35, np.pi / 2)
Pose = tuple[float, float, float]


def state(base: Pose, hand: Pose, opening: float, thing: Pose) -> np.ndarray:
    """hand and thing in the base's frame."""
    x, y, yaw = base
    back = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    goal = back @ (np.array(GOAL[:2]) - [x, y])
    return np.array(
        [*hand, 1.0, 0.0, 0.0, 0.0, x, y, 0.0, *quaternion(yaw), opening / 2, -opening / 2,
         *thing, *quaternion(0.3), *goal, 0.0, *quaternion(GOAL[2] - yaw)]
    )  # fmt: skip


def on_counter(base: Pose) -> Pose:
    return COUNTER[0] - base[0], COUNTER[1] - base[1], 0.05


@pytest.mark.parametrize(
    ("base", "hand", "opening", "thing", "phase"),
    [
        ((0.05, 0.0, 0.0), (0.5, 0.0, 0.2), OPEN, on_counter((0.05, 0.0, 0.0)), Phase.APPROACH),
        (AT_COUNTER, (0.50, 0.0, 0.16), OPEN, on_counter(AT_COUNTER), Phase.ALIGN),
        (AT_COUNTER, (0.55, 0.005, 0.155), OPEN, on_counter(AT_COUNTER), Phase.DESCEND),
        (AT_COUNTER, (0.55, 0.005, 0.085), OPEN, on_counter(AT_COUNTER), Phase.GRASP),
        (AT_COUNTER, (0.55, 0.0, 0.08), SHUT, on_counter(AT_COUNTER), Phase.LIFT),
        (AT_COUNTER, (0.55, 0.0, 0.20), SHUT, (0.55, 0.0, 0.17), Phase.TRANSPORT),
        (AT_COUNTER, (0.55, 0.0, 0.20), OPEN, on_counter(AT_COUNTER), Phase.ALIGN),  # lost it
        (STAGED, (0.52, 0.0, 0.21), SHUT, (0.52, 0.0, 0.18), Phase.ENTER),
        ((0.0, 0.95, 1.45), (0.52, 0.0, 0.21), SHUT, (0.52, 0.0, 0.18), Phase.TRANSPORT),
        (PLACING, (0.52, 0.0, 0.21), SHUT, (0.52, 0.0, 0.18), Phase.LOWER),
        (PLACING, (0.55, 0.0, 0.087), SHUT, (0.55, 0.0, 0.057), Phase.RELEASE),
        (PLACING, (0.55, 0.0, 0.120), 0.07, (0.55, 0.0, 0.090), Phase.RELEASE),
        (PLACING, (0.55, 0.0, 0.08), OPEN, (0.55, 0.0, 0.05), Phase.RETREAT),
        (STAGED, (0.55, 0.0, 0.11), OPEN, (0.95, 0.0, 0.05), Phase.RETREAT),
    ],
)  # fmt: skip
def test_one_state_says_what_an_expert_without_memory_does(
    base: Pose, hand: Pose, opening: float, thing: Pose, phase: Phase
) -> None:
    policy = OraclePolicy(8, has_memory=False)
    policy.infer(
        Observation(1, state((0.0, 0.0, 0.0), (0.5, 0.0, 0.2), OPEN, (0.9, 0.1, 0.05)), "")
    )
    rows = policy.infer(Observation(2, state(base, hand, opening, thing), ""))
    assert policy.phase == phase.value
    order = list(Phase)
    closes = order.index(Phase.GRASP) <= order.index(phase) < order.index(Phase.RELEASE)
    assert (rows[:, 6] == (1.0 if closes else -1.0)).all()


def test_without_memory_the_same_state_has_the_same_phase_whatever_came_before() -> None:
    policy, lifted = OraclePolicy(8, has_memory=False), (0.55, 0.0, 0.20)
    carried = state(AT_COUNTER, lifted, SHUT, (0.55, 0.0, 0.17))
    start = state((0.0, 0.0, 0.0), (0.5, 0.0, 0.2), OPEN, (0.9, 0.1, 0.05))
    found = []
    for tick, one in enumerate((start, carried, start, start, carried), start=1):
        policy.infer(Observation(tick, one, ""))
        found.append(policy.phase)
    assert found[1] == found[4] == Phase.TRANSPORT.value
    assert found[0] == found[2] == found[3] == Phase.APPROACH.value
