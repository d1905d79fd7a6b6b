"""ReachCube: robosuite's Lift with the cube anywhere on a wide patch; the hand has to get above it.

The hand of `Lift` on a UR5e cannot hold the cube: its linkage collides with itself as it closes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from robosuite.environments.manipulation.lift import Lift
from robosuite.utils.placement_samplers import UniformRandomSampler

X_M, Y_M = (-0.14, 0.02), (-0.13, 0.13)
"""Where the cube may lie, from the middle of the table: the camera in the hand sees it there."""

BESIDE_M, ABOVE_M = 0.015, (0.07, 0.115)
"""Success: the point between the fingertips so far beside the cube's centre at most, and so far
above it."""


class ReachCube(Lift):  # type: ignore[misc]  # robosuite ships no types
    """Success is the hand above the cube, from where it could go straight down and grasp it."""

    def _load_model(self) -> None:
        self.placement_initializer = UniformRandomSampler(
            name="ObjectSampler",
            x_range=X_M,
            y_range=Y_M,
            rotation=None,
            ensure_object_boundary_in_range=False,
            reference_pos=np.array((0, 0, 0.8)),  # the table's top, as in Lift
            z_offset=0.01,
            rng=self.rng,
        )
        super()._load_model()

    def _initialize_sim(self, xml_string: str | None = None) -> None:
        super()._initialize_sim(xml_string)
        self.sim.model._model.vis.quality.offsamples = 0  # pictures in half the time

    def task_metrics(self) -> dict[str, float]:
        """How far the hand is beside the cube and above it [m]."""
        way = self._from_cube()
        return {"beside_m": float(np.linalg.norm(way[:2])), "above_m": float(way[2])}

    def _from_cube(self) -> Any:
        data = self.sim.data
        hand = data.site_xpos[self.robots[0].eef_site_id[self.robots[0].arms[0]]]
        return hand - data.body_xpos[self.cube_body_id]

    def _check_success(self) -> bool:
        found = self.task_metrics()
        return found["beside_m"] <= BESIDE_M and ABOVE_M[0] <= found["above_m"] <= ABOVE_M[1]
