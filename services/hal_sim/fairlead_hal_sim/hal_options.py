"""Options of ``run: hal_sim`` in a deployment file."""

from __future__ import annotations

from typing import Any

from fairlead.checked_model import checked_model
from fairlead_hal_sim.options import SimulatorOptions


class HalSimOptions(SimulatorOptions):
    """A simulator's options and those of the process around it.

    trace: also record every step's vector and the simulator's state (``trace.jsonl``).
    """

    trace: bool = False


def read_options(service: str, options: dict[str, Any]) -> HalSimOptions:
    """Check a service's ``options`` block.

    Raises:
        ConfigError: naming each option that does not fit, and the valid ones.
    """
    return checked_model(f"service {service}: options", HalSimOptions, options)
