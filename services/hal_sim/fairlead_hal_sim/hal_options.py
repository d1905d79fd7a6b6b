"""Options of ``run: hal_sim`` in a deployment file."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from fairlead.errors import expected
from fairlead.plugins import HALS
from fairlead_hal_sim.options import SimulatorOptions


class HalSimOptions(SimulatorOptions):
    """A simulator's options and those of the process around it.

    trace: also record every step's vector and the simulator's state (``trace.jsonl``).
    """

    trace: bool = False

    @model_validator(mode="before")
    @classmethod
    def _has_no_backend(cls, data: Any) -> Any:
        """Another simulator is another HAL; it was an option once."""
        if isinstance(data, dict) and "backend" in data:
            choices = [f"run: {name}" for name in HALS.names()]
            what = "none, as `run` chooses the HAL"
            raise ValueError(expected("backend", what, repr(data["backend"]), choices))
        return data
