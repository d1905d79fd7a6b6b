"""``fairlead teleop`` with a gamepad that is its standard input: the kernel's bytes, no kernel.

python -m bench.faults.piped_gamepad --deployment FILE ...
"""

from __future__ import annotations

import os
import sys

import evdev

from fairlead_tools.cli.main import main

STICK = evdev.AbsInfo(value=0, min=-32768, max=32767, fuzz=0, flat=0, resolution=0)
DEVICE = "/dev/input/event0"


class PipedGamepad(evdev.InputDevice):  # type: ignore[type-arg]
    """What the library makes of a device file, of a pipe."""

    def __init__(self, dev: str, readonly: bool = False) -> None:
        self.path, self.fd = dev, sys.stdin.fileno()
        os.set_blocking(self.fd, False)

    def capabilities(self, verbose: bool = False, absinfo: bool = True) -> dict[int, list[int]]:  # type: ignore[override]
        """One button that makes it a gamepad, and a stick."""
        return {evdev.ecodes.EV_KEY: [evdev.ecodes.BTN_A], evdev.ecodes.EV_ABS: [0, 1]}

    def absinfo(self, axis_num: int) -> evdev.AbsInfo:
        """Of a stick."""
        return STICK


if __name__ == "__main__":
    evdev.InputDevice = PipedGamepad  # type: ignore[misc]
    sys.argv = ["fairlead", "teleop", "--device", DEVICE, *sys.argv[1:]]
    main()
