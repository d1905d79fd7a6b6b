"""Options of ``run: hal_kinematic`` in a deployment file; none is required."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class KinematicOptions(BaseModel):
    """What there is besides the robot.

    frames: stand still in ``odom``: name to xyz [m].
    seed: of the first episode.
    trace: also record every step's vector and the joints' state (``trace.jsonl``).
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    frames: dict[str, tuple[float, float, float]] = Field(default_factory=dict)
    seed: int = Field(default=0, ge=0)
    trace: bool = False
