"""Where demonstrations bring tools and base, and how near to a singular pose."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from bench.measure_limits.driven_robot import DrivenRobot, Moment, Tick
from fairlead.messages import FloatArray

SIX = 6


@dataclass
class Reach:
    """Boxes seen, by kind of drive: (lower, upper), and smallest singular values.

    tools: by part, T_root_tool's origin [m]. base: base_link in odom [m, m, rad]. singular: of the
    Jacobian of the tool's twist along the root's axes (rows in m and rad per unit of each joint of
    the part), by part.
    """

    tools: dict[tuple[str, str], tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    base: dict[str, tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    singular: dict[tuple[str, str], float] = field(default_factory=dict)

    def take(self, driven: DrivenRobot, ticks: Iterable[Tick]) -> Iterator[Tick]:
        """Passes the ticks on."""
        for tick in ticks:
            now, kind = tick.after, tick.kind
            self.base[kind] = _grown(self.base.get(kind), now.base)
            for part, (place, _) in now.tools.items():
                key = (part, kind)
                self.tools[key] = _grown(self.tools.get(key), place)
                # A gripper's own joint does not steer the tool it carries.
                steers = len(driven.indices(part)) >= SIX
                least = smallest_singular_value(driven, part, now) if steers else np.nan
                self.singular[key] = min(self.singular.get(key, np.inf), least)
            yield tick


def smallest_singular_value(driven: DrivenRobot, part: str, now: Moment) -> float:
    """Of the tool's Jacobian over the part's own joints."""
    root, tool, columns = driven.robot.base_frame, driven.tools[part], []
    for joint in driven.indices(part):
        one = np.zeros(len(now.velocities))
        one[joint] = 1.0
        columns.append(driven.kinematics.twist(now.positions, one, tool, root))
    return float(np.linalg.svd(np.stack(columns, axis=1), compute_uv=False)[-1])


def _grown(
    box: tuple[FloatArray, FloatArray] | None, point: FloatArray
) -> tuple[FloatArray, FloatArray]:
    if box is None:
        return point.copy(), point.copy()
    return np.minimum(box[0], point), np.maximum(box[1], point)
