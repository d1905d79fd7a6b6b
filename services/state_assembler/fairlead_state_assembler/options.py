"""Options of the assembler in a deployment file."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from fairlead_state_assembler.branches import HISTORY_TICKS


class AssemblerOptions(BaseModel):
    """max_age_ticks: by frame, how old its newest transform may be (for slow publishers)."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    max_age_ticks: dict[str, Annotated[int, Field(gt=0, le=HISTORY_TICKS)]] = Field(
        default_factory=dict
    )
