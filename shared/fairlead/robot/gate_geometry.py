"""The robot's shape and surroundings as the gate file words them."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from fairlead.errors import ConfigError
from fairlead.robot.capsules import CapsuleFile
from fairlead.robot.description import DescriptionTree, Link
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.surroundings import BaseSurroundings, SelfCollision, Volume, Workspace


def is_swept(robot: RobotManifest, tree: DescriptionTree, link: Link) -> bool:
    """Whether a link is a finger that counts as being everywhere it can be, as part of its carrier.

    The gate does not predict where it goes: nothing commands it, or only a gripper's target does.
    """
    if link.name in tree.coupled:
        return True
    if link.joint is None or robot.joint(link.joint).role != "gripper":
        return False
    modes = [part.modes for part in robot.parts if link.joint in part.joints]
    return not modes or any("gripper_position" in some for some in modes)


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
    swept = {link.name for link in tree.links if is_swept(robot, tree, link)}
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


Json = str | float | bool | None | Sequence["Json"] | dict[str, "Json"]


def compiled_shape(shape: CapsuleFile, limits: SelfCollision) -> dict[str, Json]:
    """The block ``collision``."""
    return {
        "clearance": limits.clearance_m,
        "capsules": [
            {"link": one.link, "a": one.a_m, "b": one.b_m, "radius": one.radius_m}
            for one in shape.capsules
        ],
        "pairs": shape.checked_pairs,
        "source": f"{limits.source}; capsules: {shape.source}",
    }


def compiled_workspace(workspace: Workspace) -> dict[str, Json]:
    """The block ``workspace``: volumes to keep in are smaller by the margin, others larger."""
    margin = workspace.margin_m
    return {
        "volumes": [
            {
                "name": one.name,
                "kind": one.kind,
                **_moved_edges(one, margin if one.kind == "keep_in" else -margin),
            }
            for one in workspace.volumes
        ],
        "source": workspace.source,
    }


def _moved_edges(volume: Volume, inwards: float) -> dict[str, Json]:
    if not inwards:
        return {"lower": volume.lower_m, "upper": volume.upper_m}
    return {
        "lower": [round(edge + inwards, 9) for edge in volume.lower_m],
        "upper": [round(edge - inwards, 9) for edge in volume.upper_m],
    }


def compiled_base(base: BaseSurroundings | None, joints: tuple[str, ...]) -> dict[str, Json] | None:
    """The block ``base``; None for a robot without zones."""
    if base is None:
        return None
    return {
        "joints": joints,
        "command_frame": base.command_frame,
        "yaw_axis": base.yaw_axis_m,
        "footprint": base.footprint_m,
        "reaction_s": base.reaction_s,
        "tool_drift": base.tool_drift_m,
        "clearance_drift": base.clearance_drift_m,
        "zones": [
            {"name": one.name, "kind": one.kind, "corners": one.corners_m} for one in base.zones
        ],
        "source": base.source,
    }
