"""Which service sends which transforms."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from fairlead.frames import ODOM


@dataclass(frozen=True)
class Publishers:
    """Names in ``tf/<publisher>`` that the deployment file gives.

    Attributes:
        hal: measures the base, and says which session it is.
        assembler: computes the robot's links.
        localiser: sends ``map -> odom``; "" where the HAL does.
    """

    hal: str = "hal"
    assembler: str = "state_assembler"
    localiser: str = ""

    def of_frames(self, base_frame: str, links: Iterable[str]) -> dict[str, str]:
        """The one publisher of each frame that the deployment settles beforehand."""
        owners = dict.fromkeys(links, self.assembler)
        return owners | {base_frame: self.hal, ODOM: self.localiser or self.hal}
