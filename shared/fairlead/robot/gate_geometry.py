"""The robot's shape and surroundings as the gate file words them."""

from __future__ import annotations

from collections.abc import Sequence

from fairlead.robot.capsules import CapsuleFile
from fairlead.robot.surroundings import BaseSurroundings, SelfCollision, Volume, Workspace

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
