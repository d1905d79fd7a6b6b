"""What a simulator shows so that a run can be compared bit for bit."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from fairlead.messages import FloatArray


class TraceSource(Protocol):
    """A view into the simulator behind a backend; read in the tick loop's thread."""

    def packed(self) -> npt.NDArray[np.float32]:
        """Copy of the vector given to the simulator's last step."""

    def generalized_state(self) -> tuple[FloatArray, FloatArray]:
        """Copies of the simulator's qpos and qvel now."""
