"""Routes of a skill that leave some of a tool's axes free."""

from __future__ import annotations

from collections.abc import Sequence

from fairlead.robot.free_axes import FreeAxes
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.routes import Route


def free_axes(routes: Sequence[Route], robot: RobotManifest) -> dict[int, FreeAxes]:
    """By the part's number, for each route that leaves axes free."""
    return {
        one.part: FreeAxes(robot, robot.parts[one.part], one.frame_id, one.columns)
        for one in routes
        if one.leaves_axes_free
    }
