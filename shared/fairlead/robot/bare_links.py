"""Links without capsules: the gate keeps nothing away from them, so robot.yaml has to say why."""

from __future__ import annotations

from collections.abc import Collection

from fairlead.errors import ConfigError
from fairlead.robot.description_tree import DescriptionTree, Link
from fairlead.robot.manifest import RobotManifest


def is_swept(robot: RobotManifest, link: Link) -> bool:
    """Whether a link is a finger that no command moves by itself: part of what carries it."""
    passive = link.joint in robot.passive_joint_names
    return passive and robot.joint(link.joint or "").role == "gripper"


def check_bare_links(
    robot: RobotManifest, tree: DescriptionTree, covered: Collection[str], who: str
) -> None:
    """Compare the links that have no shape with those that robot.yaml declares to have none.

    Args:
        covered: links with capsules, or with geometry that gets some.

    Raises:
        ConfigError: naming each link that is bare without a declaration, declared and not bare,
            or declared and no link.
    """
    swept = {link.name for link in tree.links if is_swept(robot, link)}
    bare = [name for name in tree.frames if name not in covered and name not in swept]
    declared = robot.no_collision_geometry
    missing = [name for name in bare if name not in declared]
    if missing:
        raise ConfigError(
            f"{who}: no collision geometry, so no capsule, for {', '.join(missing)}: give them "
            "some, or say in robot.yaml, no_collision_geometry, why each needs none"
        )
    wrong = [name for name in declared if name not in bare]
    if wrong:
        raise ConfigError(
            f"{who}: no_collision_geometry: expected links without capsules, got "
            f"{', '.join(wrong)} (valid: {', '.join(bare) or 'none'})"
        )
