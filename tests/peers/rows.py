"""What the stand-in models answer; numpy only."""

from __future__ import annotations

from typing import Any

import numpy as np

SHARES = {"end_effector_position": (0, 3), "end_effector_rotation": (3, 6),
          "gripper_close": (6, 7), "base_motion": (7, 11), "control_mode": (11, 12)}  # fmt: skip
HORIZON = 16


def overshooting() -> np.ndarray[Any, np.dtype[np.float32]]:
    """Rows a little beyond -1 and 1, as a learned policy's are."""
    return np.random.default_rng(3).uniform(-1.03, 1.03, (HORIZON, 12)).astype(np.float32)
