"""What the oracle reads from the 30-number state vector of ``mobile_pick_30d``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fairlead_skill_runner.policies.oracle.motion import Vector, turn

STATE_DIM = 30


@dataclass(frozen=True)
class Sight:
    """One observation. Positions [m]; "base" is the site at the arm's mount.

    eef, obj, goal: positions in the base frame. eef_quat: rotation of the hand in the
    base frame, xyzw. base: x, y [m] and yaw [rad] of the base in odom. goal_yaw: heading
    of the goal (into the cabinet) in odom [rad]. opening: between the fingers [m].
    """

    tick: int
    eef: Vector
    eef_quat: Vector
    base: Vector
    opening: float
    obj: Vector
    goal: Vector
    goal_yaw: float

    @property
    def obj_odom(self) -> Vector:
        """x, y of the object in odom [m]."""
        return np.asarray(self.base[:2] + turn(self.base[2]) @ self.obj[:2])

    @property
    def goal_odom(self) -> Vector:
        """x, y of the goal in odom [m]."""
        return np.asarray(self.base[:2] + turn(self.base[2]) @ self.goal[:2])

    def in_base(self, odom_xy: Vector) -> Vector:
        """x, y in the base frame of a point of odom."""
        return np.asarray(turn(-self.base[2]) @ (odom_xy - self.base[:2]))


def read_state(state: Vector, tick: int) -> Sight:
    """Slices: base_to_eef 3 + 4, world_to_base 3 + 4, gripper 2, object 3 + 4, goal 3 + 4."""
    yaw = quat_yaw(state[10:14])
    return Sight(
        tick=tick,
        eef=state[0:3].copy(),
        eef_quat=state[3:7].copy(),
        base=np.array([state[7], state[8], yaw]),
        opening=float(state[14] - state[15]),
        obj=state[16:19].copy(),
        goal=state[23:26].copy(),
        goal_yaw=yaw + quat_yaw(state[26:30]),
    )


def quat_yaw(q: Vector) -> float:
    """Heading of the x axis [rad] of a rotation given as a quaternion xyzw."""
    x, y, z, w = q
    return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def rotation_between(start: Vector, end: Vector) -> Vector:
    """Rotation vector r [rad] with ``R_end = exp(r) R_start``, from quaternions xyzw."""
    ax, ay, az, aw = end
    bx, by, bz, bw = -start[0], -start[1], -start[2], start[3]
    vector = np.array(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ]
    )
    scalar = aw * bw - ax * bx - ay * by - az * bz
    if scalar < 0:
        vector, scalar = -vector, -scalar
    norm = float(np.linalg.norm(vector))
    if norm < 1e-9:
        return 2 * vector
    return np.asarray(vector / norm * 2 * np.arctan2(norm, scalar))
