"""Where a robot rests: what robot.yaml may declare, and what no gate file is compiled from."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.robot.capsule_distance import capsule_spans, pair_distances
from fairlead.robot.capsules import load_capsules
from fairlead.robot.description import description_tree
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.link_poses import link_poses
from fairlead.robot.manifest import RobotManifest, load_robot

ROBOT = load_robot("panda_mobile")


def resting_with(**positions: float) -> RobotManifest:
    """The mobile robot with some of its joints elsewhere at home."""
    assert ROBOT.home is not None
    home = ROBOT.home.model_copy(update={"positions": {**ROBOT.home.positions, **positions}})
    return ROBOT.model_copy(update={"home": home})


def nearest_m(robot: RobotManifest) -> float:
    """Of all checked pairs at home."""
    assert robot.home is not None
    tree, shape = description_tree(robot), load_capsules(robot)
    at = {
        link.joint: np.array([robot.home.positions.get(link.joint, 0.0)])
        for link in tree.links
        if link.joint
    }
    spans = capsule_spans(shape.capsules, link_poses(tree, at))
    return min(float(pair_distances(shape.capsules, spans, *p)[0]) for p in shape.checked_pairs)


def test_at_home_links_are_far_enough_apart_for_the_bases_full_speed() -> None:
    """Nearer than this the gate slows the base down (G032)."""
    limits = ROBOT.profile("sim")
    assert limits.base is not None
    assert nearest_m(ROBOT) > limits.self_collision.clearance_m + limits.base.clearance_drift_m


@pytest.mark.parametrize(
    ("profile", "wrist", "clearance"), [("sim", -0.0175, "0.01"), ("hardware", 2.1, "0.02")]
)
def test_a_home_in_which_links_are_too_near_each_other_is_refused(
    profile: str, wrist: float, clearance: str
) -> None:
    robot = resting_with(panda_joint4=-3.07, panda_joint6=wrist)
    assert nearest_m(robot) < float(clearance)
    with pytest.raises(ConfigError) as error:
        compile_gate_config(robot, profile)
    assert str(error.value).startswith("robot panda_mobile: home: expected ")
    assert f"at least {clearance} m apart (safety.{profile}: self_collision), got " in str(
        error.value
    )


def test_a_home_just_beside_what_the_gate_refuses_is_compiled() -> None:
    clearance_m = ROBOT.profile("sim").self_collision.clearance_m
    passes, fails = 2.74159, -0.0175
    while passes - fails > 0.007:
        middle = (passes + fails) / 2
        if nearest_m(resting_with(panda_joint6=middle)) < clearance_m:
            fails = middle
        else:
            passes = middle
    assert compile_gate_config(resting_with(panda_joint6=passes), "sim")
    with pytest.raises(ConfigError, match="robot panda_mobile: home: expected "):
        compile_gate_config(resting_with(panda_joint6=fails), "sim")
