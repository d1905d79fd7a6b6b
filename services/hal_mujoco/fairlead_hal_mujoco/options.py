"""Options of ``run: hal_mujoco`` in a deployment file; none is required."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class MujocoOptions(BaseModel):
    """What to simulate.

    An episode starts at `home` of robot.yaml, else at key ``home``; success is to rest at key
    ``goal``.

    model: MJCF file, relative to the robot's folder; None: ``<robot>.xml`` there.
    seed: of the first episode.
    start_spread_rad: an episode starts this far around key ``home`` at most (turning joints).
    goal_tolerance_rad, goal_tolerance_m: how near to key ``goal`` is there.
    trace: also record every step's setpoints and the simulator's state (``trace.jsonl``).
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    model: str | None = None
    seed: int = Field(default=0, ge=0)
    start_spread_rad: float = Field(default=0.05, ge=0, allow_inf_nan=False)
    goal_tolerance_rad: Positive = 0.02
    goal_tolerance_m: Positive = 0.002
    trace: bool = False
