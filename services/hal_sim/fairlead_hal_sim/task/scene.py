"""One episode's scene: where the robot starts and where counter, can and cabinet stand.

Everything is in the simulator's world frame, z up, floor at z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

COUNTER_HEIGHT_M = 0.90

SHELF_HEIGHT_M = 0.90
CABINET_DEPTH_M = 0.40
CABINET_WIDTH_M = 0.60
CABINET_INTERIOR_HEIGHT_M = 0.55

CAN_HEIGHT_M = 0.100


@dataclass(frozen=True)
class PlanarPose:
    """A pose on the floor: x, y [m] and yaw [rad] in the world frame."""

    x: float
    y: float
    yaw: float

    def at(self, local_x: float, local_y: float) -> tuple[float, float]:
        """World x, y [m] of a point given in this pose's frame."""
        cos, sin = np.cos(self.yaw), np.sin(self.yaw)
        return (
            float(self.x + cos * local_x - sin * local_y),
            float(self.y + sin * local_x + cos * local_y),
        )


@dataclass(frozen=True)
class Scene:
    """What one seed draws.

    robot_start: displacement of the base joints base_x, base_y [m] (the heading is 0).
    counter, cabinet: frame in the middle of the front edge, x axis pointing inwards.
    can: planar pose of the can, which stands upright on the counter.
    """

    robot_start: tuple[float, float]
    counter: PlanarPose
    can: PlanarPose
    cabinet: PlanarPose


def sample_scene(rng: np.random.Generator) -> Scene:
    """Draw a scene; the draws and their order are part of what a seed means.

    The cabinet is 1.6 to 1.9 m to the left of the robot's start, out of the arm's reach
    (0.85 m), so the base has to drive.
    """
    start_x, start_y = rng.uniform(-0.10, 0.10, size=2)
    counter = PlanarPose(x=0.80 + rng.uniform(-0.03, 0.03), y=0.0, yaw=rng.uniform(-0.08, 0.08))
    can_x, can_y = counter.at(rng.uniform(0.11, 0.17), rng.uniform(-0.20, 0.20))
    cabinet = PlanarPose(
        x=rng.uniform(-0.15, 0.15),
        y=rng.uniform(1.65, 1.85),
        yaw=np.pi / 2 + rng.uniform(-0.12, 0.12),
    )
    return Scene(
        robot_start=(float(start_x), float(start_y)),
        counter=counter,
        can=PlanarPose(can_x, can_y, rng.uniform(-np.pi, np.pi)),
        cabinet=cabinet,
    )
