"""Whether a robot can stand where it is declared to rest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.robot.capsule_distance import capsule_spans, pair_distances
from fairlead.robot.capsules import CapsuleFile
from fairlead.robot.description import DescriptionTree, description_tree
from fairlead.robot.executed_way import limits_for_the_gate
from fairlead.robot.link_poses import link_poses
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.tool_chain import ToolChain


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


def singular_homes(robot: RobotManifest) -> dict[str, str]:
    """By part, in words, that the gate refuses its tool modes at home (G033).

    From above half of the limit they may lead away.

    Joints without a home count as at 0.
    """
    if robot.home is None:
        return {}
    found = {}
    for name, value in smallest_singular_values(robot, robot.home.positions).items():
        limits = [profile.parts[name].singularity_limit for profile in robot.safety.values()]
        limit = max((one for one in limits if one is not None), default=0.0)
        if value < limit:
            found[name] = (
                f"home is singular for the tool of {name}: smallest singular value "
                f"{value:.2g}, limit {limit:g}"
            )
    return found


def smallest_singular_values(
    robot: RobotManifest, positions: Mapping[str, float]
) -> dict[str, float]:
    """Of the Jacobian of each part's tool [m]; joints that are not named count as at 0."""
    tree, found = description_tree(robot), {}
    at = dict.fromkeys((one.joint for one in tree.links if one.joint), 0.0) | dict(positions)
    for part in robot.parts:
        if part.end_effector is not None and part.joints:
            tool = robot.end_effector(part.end_effector).tool_frame
            jacobian = ToolChain(tree, tool).jacobian(at, part.joints)
            found[part.name] = float(np.linalg.svd(jacobian, compute_uv=False).min())
    return found
