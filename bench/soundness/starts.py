"""Configurations to start from: anywhere that is allowed, and close to where it ends."""

from __future__ import annotations

import numpy as np

from bench.soundness.arena import Arena
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest

POOL = 4000
NEAR_SHARE = 0.15
SPREAD_M = 3.0


class Starts:
    """A pool of configurations without a breach, and those of them with the least room.

    around: configurations of demonstrations, which are mixed in.
    """

    def __init__(
        self,
        robot: RobotManifest,
        arena: Arena,
        around: FloatArray,
        rng: np.random.Generator,
    ) -> None:
        self._rng, self._arena, self._robot = rng, arena, robot
        pool = np.concatenate([self._uniform(POOL), self._scattered(around, POOL)])
        rooms = arena.room(pool)
        room = np.min([*rooms.values()], axis=0)
        # The gate keeps a clearance between capsules; from within it only leaving is allowed.
        free = (room > 0.0) & (rooms["self-collision"] > arena.clearance)
        self.pool = pool[free]
        self._near = self._least(room[free])
        self._folded = self._least(rooms["self-collision"][free])

    def pick(self, near: bool) -> FloatArray:
        """One configuration, shape ``[measured]``."""
        return self._one_of(self._near if near else self.pool)

    def pick_folded(self) -> FloatArray:
        """One that is close to a self-collision."""
        return self._one_of(self._folded)

    def _least(self, room: FloatArray) -> FloatArray:
        least = np.argsort(room)[: max(1, int(NEAR_SHARE * len(room)))]
        return np.asarray(self.pool[least])

    def _one_of(self, choice: FloatArray) -> FloatArray:
        return np.array(choice[int(self._rng.integers(len(choice)))])

    def _uniform(self, count: int) -> FloatArray:
        found = []
        for joint in (*self._robot.joints, *self._robot.passive_joints):
            lower, upper = (joint.lower, joint.upper) if joint.has_bounds else (-1.0, 1.0)
            spread = 1.0 if joint.has_bounds else SPREAD_M
            found.append(self._rng.uniform(lower * spread, upper * spread, count))
        return np.stack(found, axis=1)

    def _scattered(self, around: FloatArray, count: int) -> FloatArray:
        picked = around[self._rng.integers(len(around), size=count)].copy()
        own = picked[:, : self._robot.n_dof]
        own += self._rng.normal(0.0, 0.15, own.shape)
        low = np.where(np.isfinite(self._arena.lower), self._arena.lower, -np.inf)
        picked[:, : self._robot.n_dof] = np.clip(own, low, self._arena.upper)
        return np.asarray(picked)
