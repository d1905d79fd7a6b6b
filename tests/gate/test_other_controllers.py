"""Joints of a tool motion are the controller's choice: the gate's prediction beside other dampings.

The gate follows damped least squares. Whatever the damping of the robot's own controller, it must
not get far from there, or be refused.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

from fairlead.messages import FloatArray
from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot
from tests.gate.joint_samples import samples
from tests.gate.pinocchio_tool import HARDLY, PinocchioTool, damped, motion_between, moved, probe

STARTS, SHIFT_M, TURN_RAD = 2000, 0.02, 0.08
DAMPINGS = (0.001, 0.05)
STEPS, REACHED = 2000, 1e-8
FASTEST = 0.109
"""The panda's slower joints in 50 ms [rad]: G026 lets through no first step that is larger."""


def reached(tool: PinocchioTool, start: FloatArray, motion: FloatArray, by: float) -> FloatArray:
    """Joints of a controller that goes on until the tool is there, with that damping."""
    goal, q = moved(tool.seen(start)[1], motion), start.copy()
    for _ in range(STEPS):
        jacobian, there = tool.seen(q)
        missing = motion_between(there, goal)
        if np.abs(missing).max() < REACHED:
            break
        q[tool.own] += damped(jacobian, missing, by)
    return q


def some_motions(
    rng: np.random.Generator, count: int, shift_m: float, turn_rad: float
) -> FloatArray:
    """Of a tool, shape ``[count, 6]``: up to so far, in any direction."""
    motions = rng.normal(size=(count, 6))
    for half, size in ((slice(0, 3), shift_m), (slice(3, 6), turn_rad)):
        lengths = np.linalg.norm(motions[:, half], axis=1, keepdims=True)
        motions[:, half] *= size * rng.random((count, 1)) / lengths
    return motions


@pytest.mark.processes
@pytest.mark.parametrize(
    ("least", "most", "apart"), [(0.05, 0.07, 0.010), (0.03, 0.05, 0.012), (0.0, 0.03, 0.02)]
)
@pytest.mark.parametrize(("name", "part"), [("panda_mobile", "arm"), ("dual_panda", "left_arm")])
def test_other_dampings_lead_to_the_joints_that_the_gate_predicts(
    name: str, part: str, least: float, most: float, apart: float
) -> None:
    """Between these smallest singular values no joint ends further apart than that [rad]."""
    robot, rng = load_robot(name), np.random.default_rng(3)
    tool = PinocchioTool(robot, part)
    starts = np.array([q for q in samples(robot, STARTS)[0] if least <= _value(tool, q) < most])
    motions = some_motions(rng, len(starts), SHIFT_M, TURN_RAD)
    answers = probe(np.hstack([starts, motions]), "tool", gate_config(name, "sim"), part)
    found = []
    for q, motion, answer in zip(starts, motions, answers.reshape(len(starts), -1), strict=True):
        straight = damped(tool.seen(q)[0], motion, HARDLY)
        ways = np.abs([straight, (answer[8:] - q)[tool.own]])
        if answer[6] != 1.0 or ways.max() > FASTEST or _value(tool, answer[8:]) < _value(tool, q):
            continue  # G030, G026; G033, which lets through what leaves a singularity
        found += [np.abs(reached(tool, q, motion, by) - answer[8:]).max() for by in DAMPINGS]
    assert len(found) > 50
    assert max(found) <= apart


def _value(tool: PinocchioTool, q: FloatArray) -> float:
    return float(np.linalg.svd(tool.seen(q)[0], compute_uv=False).min())


@pytest.mark.processes
@pytest.mark.parametrize(
    ("name", "part"),
    [("panda_mobile", "arm"), ("dual_panda", "left_arm"), ("so101", "arm"), ("ur5e", "arm"),
     ("kinova3", "arm")],
)  # fmt: skip
def test_between_the_ends_and_the_middle_of_a_gain_joints_go_hardly_further(
    name: str, part: str
) -> None:
    """By the gate's own search, of rows as large as they may be that pass there."""
    robot, rng, config = load_robot(name), np.random.default_rng(2), gate_config(name, "sim")
    data = json.loads(config.read_text())
    limits = next(one for one in data["parts"] if one["name"] == part)
    mode, own = limits["modes"]["cartesian_delta"], limits["joints"]
    speeds = np.array([one["velocity_limit"] for one in data["joints"] if one["name"] in own])
    fastest = speeds * data["period_ns"] * 1e-9
    joints = [robot.measured_joint_names.index(joint) for joint in own]
    starts = samples(robot, 2 * STARTS)[0]
    motions = some_motions(
        rng, len(starts), mode["linear_step_limit"], mode["angular_step_limit"]
    ) * np.isin(np.arange(6), mode.get("free_axes", range(6)))

    def led(share: float, begins: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Where the joints get to, whether the gate says so, the least singular value before."""
        sent = np.hstack([begins, share * motions])
        answers = probe(sent, "tool", config, part).reshape(len(begins), -1)
        return answers[:, 8:], answers[:, 6] == 1.0, answers[:, 7]

    straight = (led(1e-6, starts)[0] - starts)[:, joints] * 1e6
    passes, ways = led(0.0, starts)[2] >= 0.5 * limits["singularity_limit"], []
    low, high = map(float, mode["gain"])
    for number, share in enumerate(np.linspace(low, high, 9)):
        ends, is_solved, _ = led(share, starts)
        ways.append((ends - starts)[:, joints])
        if number % 4 == 0:  # an end or the middle
            passes &= is_solved & (led(0.0, ends)[2] >= limits["singularity_limit"])
            passes &= (np.maximum(np.abs(ways[-1]), np.abs(share * straight)) <= fastest).all(1)
    way, judged = np.array(ways)[:, passes], np.array(ways[::4])[:, passes]
    further = np.maximum(way.max(0) - judged.max(0), judged.min(0) - way.min(0))
    assert passes.sum() > 100
    assert further.max() <= 2e-3
    assert (np.abs(way) <= 1.02 * fastest).all()


@pytest.mark.processes
def test_a_row_through_a_singularity_is_refused_at_each_end_of_its_gain() -> None:
    """Between them a controller with a damping of 0.001 would move a joint by 2 rad."""
    start = [-0.03850954, -1.90721147, 1.57323955, -2.93491980, 0.03108047, 0.72477818]
    motion = np.array([-0.00439358, 0.00486523, 0.03332954, 0.00966162, -0.10934754, -0.10581488])
    config = gate_config("ur5e", "sim")
    q = np.zeros(len(load_robot("ur5e").measured_joint_names))
    q[:6] = start
    for share in (0.25, 0.525, 1.05):
        assert probe(np.hstack([q, share * motion]), "tool", config, "arm")[6] == 0.0
