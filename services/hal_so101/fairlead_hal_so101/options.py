"""Options of ``run: hal_so101`` in a deployment file; ``port`` is required."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class ServoLimits(BaseModel):
    """What a servo may measure; beyond it for ``ticks`` ticks in a row, rows are refused.

    temperature_c: it lets go by itself at 70. voltage_v: lowest and highest, of the 12 V variant.
    current_a: of 2.7 when stalled. load: share of its full duty cycle.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    temperature_c: Positive = 60.0
    voltage_v: tuple[Positive, Positive] = (10.0, 13.0)
    current_a: Positive = 1.5
    load: Positive = 0.8
    ticks: int = Field(default=10, ge=1, le=1000)


class So101Options(BaseModel):
    """Which arm, and what becomes of it.

    port: its serial port. calibration: a name in the user's folder, or a path to the file.
    torque_off_at_exit: limp at the end, so that it falls; else it holds on.
    answer_timeout_s: for one servo. lost_ticks: measurements lost in a row that are no fault.
    limits: what the servos may measure.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    port: str = Field(min_length=1)
    calibration: str = "so101"
    torque_off_at_exit: bool = False
    answer_timeout_s: float = Field(default=0.008, ge=0.001, le=1.0)
    lost_ticks: int = Field(default=4, ge=0, le=100)
    limits: ServoLimits = ServoLimits()
