"""A HAL without physics, for what is not about what the robot touches."""

from __future__ import annotations

from typing import Any, Literal

Pacing = Literal["realtime", "lockstep"]
LIGHT_HAL: dict[str, Any] = {
    "run": "hal_kinematic",
    "options": {"frames": {"object": [0.6, 0.0, 0.95], "goal": [0.0, 1.8, 1.1]}},
}
"""Of a deployment's services, with the frames that shipped skills ask for [m]."""
