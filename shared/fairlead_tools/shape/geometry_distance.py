"""How near the links themselves come, as the simulator measures it between their geoms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from fairlead.messages import FloatArray
from fairlead.robot.link_poses import Poses
from fairlead_tools.shape.geometry_source import GeometrySource

_FAR_M = 1.0  # farther apart is told as this
_NUDGE_M, _TRIES = 1e-6, 5


def links_apart(
    source: GeometrySource,
    poses: Mapping[str, Poses],
    first: Sequence[str],
    second: Sequence[str],
) -> FloatArray:
    """Smallest distance between two groups of links in each pose, shape ``[n]`` [m].

    Negative where they overlap.
    """
    data = mujoco.MjData(source.model)
    geoms = [[one for link in group for one in source.geoms(link)] for group in (first, second)]
    count = len(next(iter(poses.values())).translation)
    far = np.full(count, _FAR_M)
    for pose in range(count):
        for link, geom, rotation, translation in geoms[0] + geoms[1]:
            placed = poses[link].rotation[pose]
            data.geom_xpos[geom] = placed @ translation + poses[link].translation[pose]
            data.geom_xmat[geom] = (placed @ rotation).ravel()
        far[pose] = min(
            (
                _apart(source.model, data, one[1], other[1])
                for one in geoms[0]
                for other in geoms[1]
            ),
            default=_FAR_M,
        )
    return far


def _apart(model: mujoco.MjModel, data: mujoco.MjData, first: int, second: int) -> float:
    """MuJoCo now and then answers 0 for geoms that are apart; moved by a hair it does not."""
    for _ in range(_TRIES):
        distance = float(mujoco.mj_geomDistance(model, data, first, second, _FAR_M, None))
        if distance != 0.0:
            return distance
        data.geom_xpos[first] += _NUDGE_M
    return 0.0
