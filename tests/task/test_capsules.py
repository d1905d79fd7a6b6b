"""The scripted expert's work keeps clear of the robot's own shape."""

from __future__ import annotations

import numpy as np
import pytest

from bench.equipment.expert_episode import run_episode
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.robot.capsule_distance import capsule_spans, pair_distances
from fairlead.robot.capsules import load_capsules
from fairlead.robot.description import description_tree
from fairlead.robot.link_poses import link_poses
from fairlead.robot.manifest import load_robot
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

pytestmark = pytest.mark.simulator

CLEARANCE_M = 0.01
MARGIN_M = 0.015  # on top of it; measured: 0.028 m between the two nearest capsules


def test_an_episode_of_the_expert_keeps_every_pair_apart(
    backend: RobosuiteBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    states: list[FloatArray] = []
    apply = backend.apply

    def recorded(commands: dict[str, PartCommand]) -> object:
        done = apply(commands)
        states.append(np.array(backend.read().positions))
        return done

    monkeypatch.setattr(backend, "apply", recorded)
    assert run_episode(backend, 0).success_tick is not None
    robot, measured = load_robot("panda_mobile"), np.array(states)
    file, tree = load_capsules(robot), description_tree(robot)
    columns = {name: measured[:, i] for i, name in enumerate(robot.measured_joint_names)}
    spans = capsule_spans(file.capsules, link_poses(tree, columns))
    least = {
        pair: float(pair_distances(file.capsules, spans, *pair).min())
        for pair in file.checked_pairs
    }
    assert len(states) > 100
    assert robot.profile("sim").self_collision.clearance_m == CLEARANCE_M
    assert {pair: far for pair, far in least.items() if far < CLEARANCE_M + MARGIN_M} == {}
    assert min(least.values()) < 0.1  # the arm is folded: were it not, this would prove little
