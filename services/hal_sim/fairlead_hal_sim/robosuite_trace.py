"""Shows the simulator behind a `RobosuiteBackend` to the HAL's trace log."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fairlead.messages import FloatArray
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend


class RobosuiteTrace:
    """Implements `fairlead.hal.backend.TraceSource`."""

    def __init__(self, backend: RobosuiteBackend) -> None:
        self._backend = backend

    def packed(self) -> npt.NDArray[np.float32]:
        """The float32 vector of the newest ``env.step``; empty before an episode's first."""
        packed = self._backend.last_packed
        return np.zeros(0, dtype=np.float32) if packed is None else packed.copy()

    def generalized_state(self) -> tuple[FloatArray, FloatArray]:
        """MuJoCo's ``qpos`` and ``qvel`` now, in the model's order."""
        data = self._backend.env.sim.data
        return np.array(data.qpos, dtype=np.float64), np.array(data.qvel, dtype=np.float64)
