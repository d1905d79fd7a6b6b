"""Whether a robot can stand where it is declared to rest."""

from __future__ import annotations

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.robot.capsule_distance import capsule_spans, pair_distances
from fairlead.robot.capsules import CapsuleFile
from fairlead.robot.description import DescriptionTree
from fairlead.robot.executed_way import limits_for_the_gate
from fairlead.robot.link_poses import link_poses
from fairlead.robot.manifest import RobotManifest


def check_home(
    robot: RobotManifest, profile: str, tree: DescriptionTree, shape: CapsuleFile
) -> None:
    """Whether the gate would let the links be as near each other as they are at home.

    Raises:
        ConfigError: naming the nearest two, if it would not.
    """
    if robot.home is None:
        return
    safety = limits_for_the_gate(robot, profile, tree, shape)
    positions, clearance_m = robot.home.positions, safety.self_collision.clearance_m
    at = {one.joint: np.array([positions.get(one.joint, 0.0)]) for one in tree.links if one.joint}
    spans, capsules = capsule_spans(shape.capsules, link_poses(tree, at)), shape.capsules
    near = [(float(pair_distances(capsules, spans, *p)[0]), *p) for p in shape.checked_pairs]
    least_m, first, second = min(near, default=(np.inf, 0, 0))
    if least_m < clearance_m:
        links = f"{capsules[first].link} and {capsules[second].link}"
        wanted = f"{links} at least {clearance_m:g} m apart (safety.{profile}: self_collision)"
        raise ConfigError(expected(f"robot {robot.id}: home", wanted, f"{least_m:.4f} m"))
