"""Options of a HAL without physics, for tests that are not about what the robot touches."""

from __future__ import annotations

from typing import Literal

Pacing = Literal["realtime", "lockstep"]
LIGHT_HAL = {
    "backend": "kinematic",
    "frames": {"object": [0.6, 0.0, 0.95], "goal": [0.0, 1.8, 1.1]},
}
