"""Options of ``run: hal_sim`` in a deployment file."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from fairlead.checked_model import checked_model
from fairlead_hal_sim.options import SimulatorOptions


class HalSimOptions(SimulatorOptions):
    """A simulator's options and those of the process around it.

    backend: ``robosuite``, or ``kinematic`` (commands are integrated, no physics).
    trace: also record every step's vector and the simulator's state (``trace.jsonl``).
    frames: kinematic backend only, frames that stand still in ``odom``: name to xyz [m].
    """

    backend: Literal["robosuite", "kinematic"] = "robosuite"
    trace: bool = False
    frames: dict[str, tuple[float, float, float]] = Field(default_factory=dict)


def read_options(service: str, options: dict[str, Any]) -> HalSimOptions:
    """Check a service's ``options`` block.

    Raises:
        ConfigError: naming each option that does not fit, and the valid ones.
    """
    return checked_model(f"service {service}: options", HalSimOptions, options)
