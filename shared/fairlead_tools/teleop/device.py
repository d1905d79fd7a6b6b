"""What drives a robot by hand: a keyboard, a gamepad, or anything else that can say this much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from fairlead.messages import FloatArray

Wish = Literal["", "give back", "quit"]


@dataclass(frozen=True)
class Deflection:
    """What a device asks for at one moment.

    axes: per axis of the drive, in [-1, 1]: the share of full speed, and its direction.
    grip: in [-1, 1], above 0 opens, below 0 closes.
    clutch: nothing moves without it.
    speed: in [0, 1], the share of full speed that ``axes`` are shares of.
    age_s: how long ago the device said so; older than its `InputDevice.silence_s` it counts
        as centred.
    wish: to give parts back to the policy they were taken from, or to end.
    opening: where the gripper is wanted, instead of ``grip``: share of its range, 1 is open.
    note: what the device has to tell the person now.
    """

    axes: tuple[float, ...]
    grip: float = 0.0
    clutch: bool = False
    speed: float = 0.0
    age_s: float = 0.0
    wish: Wish = ""
    opening: float | None = None
    note: str = ""


class InputDevice(Protocol):
    """Where deflections come from: the one thing that another device has to be."""

    @property
    def silence_s(self) -> float:
        """A deflection is believed for so long after the device said it [s]."""
        ...

    @property
    def help(self) -> str:
        """How it is used, one line for a person."""
        ...

    def read(self, now_s: float, at: FloatArray) -> Deflection:
        """What is asked for now; never waits.

        Args:
            now_s: monotonic time [s].
            at: where each axis of the drive is [rad or m]; of axes that are told rates, how far
                it has come since the start.

        Raises:
            ServiceError: the device is gone.
        """
        ...
