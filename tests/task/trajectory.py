"""Every bit of an episode under random commands; as a program, in a process of its own."""

from __future__ import annotations

import hashlib
import sys

import numpy as np

from bench.equipment.expert_episode import commands
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

TICKS = 60


def trajectory(backend: RobosuiteBackend, seed: int) -> str:
    """Hash of qpos, qvel, packed vectors and readings under random commands."""
    backend.reset(seed)
    rng = np.random.default_rng(99)
    digest = hashlib.sha256()
    for _ in range(TICKS):
        row = rng.uniform(-1, 1, 12).astype(np.float32)
        row[6] = np.sign(row[6])
        backend.apply(commands(row))
        data = backend.env.sim.data
        measured = backend.read()
        for block in (data.qpos, data.qvel, measured.positions, measured.efforts):
            digest.update(np.ascontiguousarray(block).tobytes())
        for frame in backend.transforms():
            digest.update(frame.translation.tobytes() + frame.rotation_xyzw.tobytes())
        assert backend.last_packed is not None
        digest.update(backend.last_packed.tobytes())
    return digest.hexdigest()


if __name__ == "__main__":
    # Another history on purpose: made with another seed, one episode behind it.
    fresh = RobosuiteBackend(SimulatorOptions(seed=4))
    trajectory(fresh, 1)
    print(trajectory(fresh, int(sys.argv[1])))
