"""A gamepad's events, as the kernel writes them, through the library that reads them.

No gamepad and no /dev/uinput is needed: the bytes of its events come through a pipe.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator

import evdev
import numpy as np
import pytest

from fairlead.errors import ServiceError
from fairlead_tools.teleop.device import Deflection
from fairlead_tools.teleop.gamepad import SILENCE_S, Gamepad, Pad
from fairlead_tools.teleop.pilot import Pilot
from tests.teleop.drives import drive

TOOL = drive("ur5e", "arm", "cartesian_delta")
STICK, TRIGGER, CROSS = (-32768, 32767), (0, 1023), (-1, 1)
RANGES = {0: STICK, 1: STICK, 2: TRIGGER, 3: STICK, 4: STICK, 5: TRIGGER, 16: CROSS, 17: CROSS}
SYN, KEY, ABS = 0, 1, 3
RIGHT_SHOULDER, START, SELECT, B, Y = 311, 315, 314, 305, 308
AT = np.zeros(6)


class Plugged:
    """The library's device with a pipe where the kernel's would be."""

    def __init__(self, names: tuple[str, ...] = TOOL.names) -> None:
        there, self._here = os.pipe()
        os.set_blocking(there, False)
        self.device = evdev.InputDevice.__new__(evdev.InputDevice)
        self.device.fd = there
        self.gamepad = Gamepad(Pad(names, 0.5, RANGES), self.device)

    def says(self, *events: tuple[int, int, int], now_s: float = 1.0) -> Deflection:
        for kind, code, value in (*events, (SYN, 0, 0)):
            os.write(self._here, struct.pack("llHHi", 7, 8, kind, code, value))
        return self.gamepad.read(now_s, AT)

    def end(self) -> None:
        os.close(self._here)
        self.gamepad.__exit__()


@pytest.fixture
def plugged() -> Iterator[Plugged]:
    made = Plugged()
    yield made
    made.end()


@pytest.mark.parametrize(
    ("event", "axes"),
    [
        ((ABS, 1, -32768), (1, 0, 0, 0, 0, 0)),
        ((ABS, 0, -32768), (0, 1, 0, 0, 0, 0)),
        ((ABS, 5, 1023), (0, 0, 1, 0, 0, 0)),
        ((ABS, 2, 1023), (0, 0, -1, 0, 0, 0)),
        ((ABS, 16, 1), (0, 0, 0, 1, 0, 0)),
        ((ABS, 4, -32768), (0, 0, 0, 0, 1, 0)),
        ((ABS, 3, 32767), (0, 0, 0, 0, 0, -1)),
        ((ABS, 0, 3000), (0, 0, 0, 0, 0, 0)),
        ((ABS, 40, 1), (0, 0, 0, 0, 0, 0)),
    ],
)
def test_a_stick_drives_its_axis_beyond_the_dead_zone(
    plugged: Plugged, event: tuple[int, int, int], axes: tuple[float, ...]
) -> None:
    assert plugged.says(event).axes == pytest.approx(axes)


def test_the_clutch_is_in_while_the_shoulder_button_is_held(plugged: Plugged) -> None:
    assert plugged.says((KEY, RIGHT_SHOULDER, 1), (KEY, B, 1)).clutch
    held = plugged.says((KEY, Y, 1))
    assert (held.clutch, held.grip, held.speed) == (True, 1.0, 0.625)
    assert not plugged.says((KEY, RIGHT_SHOULDER, 0)).clutch
    assert plugged.says((KEY, START, 1)).wish == "give back"
    assert (plugged.says((KEY, SELECT, 1)).wish, plugged.says().wish) == ("quit", "")


def test_one_that_falls_silent_while_deflected_stops_the_robot_until_it_speaks(
    plugged: Plugged,
) -> None:
    pilot = Pilot(TOOL, ahead=0, horizon=64, silence_s=plugged.gamepad.silence_s)

    def moves(now_s: float, tick: int, asked: Deflection) -> bool:
        pilot.rows(tick, AT, False, asked)
        pilot.judged(tick + 63)
        return not pilot.at_rest

    plugged.says((KEY, RIGHT_SHOULDER, 1), (ABS, 1, -32768))
    tick, now_s, moved = 0, 1.0, []
    while now_s < 1.0 + SILENCE_S + 0.5:
        tick, now_s = tick + 1, now_s + 0.05
        moved.append(moves(now_s, tick, plugged.gamepad.read(now_s, AT)))
    stopped_after_s = 0.05 * (1 + max(index for index, one in enumerate(moved) if one))
    assert SILENCE_S - 0.1 < stopped_after_s <= SILENCE_S + 0.2
    assert moves(now_s, tick + 1, plugged.says((ABS, 0, 100), now_s=now_s))


def test_one_that_is_unplugged_is_an_error(plugged: Plugged) -> None:
    os.close(plugged.device.fd)
    with pytest.raises(ServiceError, match=r"^gamepad: it is gone \(.*\); the robot holds$"):
        plugged.gamepad.read(1.0, AT)
    plugged.device.fd = -1


def test_where_events_were_lost_nothing_counts_as_held_any_more(plugged: Plugged) -> None:
    held = plugged.says((KEY, RIGHT_SHOULDER, 1), (KEY, B, 1), (ABS, 1, -32768))
    assert held.clutch and held.axes[0] == 1 and held.grip == 1
    lost = plugged.says((SYN, 3, 0), (KEY, RIGHT_SHOULDER, 1), (ABS, 4, 32767), now_s=2.0)
    assert not lost.clutch and lost.axes == (0,) * 6 and lost.grip == 0
    assert lost.age_s == 1.0, "what was lost says nothing"
    assert plugged.says((KEY, RIGHT_SHOULDER, 1)).clutch
