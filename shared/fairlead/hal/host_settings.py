"""How one HAL is deployed."""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.hal.core import Pacing
from fairlead.keys import Keys


@dataclass(frozen=True)
class HostSettings:
    """What every piece of the host has to know.

    service: its name in the deployment file, in keys and in log lines.
    session: a random number that is this run of the HAL.
    localiser: who says where ``odom`` is in ``map``; "" for this HAL.
    """

    service: str
    keys: Keys
    pacing: Pacing
    session: int
    localiser: str = ""

    @property
    def lockstep(self) -> bool:
        """Whether the world waits for the decision on its tick."""
        return self.pacing == "lockstep"
