"""A terminal's keyboard as an input device: keys held drive, the space bar is the clutch."""

from __future__ import annotations

import math
import os
import select
import sys
import termios
import tty
from contextlib import suppress

from fairlead.errors import ConfigError, ServiceError, expected
from fairlead.messages import FloatArray
from fairlead_tools.teleop.device import Deflection, Wish

HELD_S = 0.2
"""A terminal tells no key's release: one counts as held for so long after it, or its repeat, came.

Terminals repeat a key that is held every 20 to 100 ms, after a first pause of 0.25 to 0.7 s.
"""
AGAIN_S = 1.0
"""A space that comes so soon after another may be its repeat: it only lets the clutch out."""
ESCAPE_S = 0.1
"""The letters of one key come as fast as a network brings them."""
SPEED_STEP = 1.25
SLOWEST = 0.02
_ESCAPE = "\x1b"
_POSITIVE, _NEGATIVE = "qwertyuiop", "asdfghjkl;"
_AXES = {
    "x": ("w", "s"),
    "y": ("a", "d"),
    "z": ("r", "f"),
    "rx": ("o", "u"),
    "ry": ("i", "k"),
    "rz": ("j", "l"),
}
_WISHES: dict[str, Wish] = {"b": "give back", "x": "quit", "\x04": "quit"}
_GRIP = {"v": 1.0, "c": -1.0}


class Keys:
    """What keys that came mean, without a terminal.

    Args:
        names: axes of the drive, as in `Drive.names`; none: another device moves them.
        speed: share of full speed at the start.

    Raises:
        ConfigError: more joints than there are pairs of keys.
    """

    def __init__(self, names: tuple[str, ...], speed: float) -> None:
        self._clutch, self._speed, self._wish = False, speed, _NONE
        self._pairs = [_AXES[name] for name in names if name in _AXES]
        if len(self._pairs) < len(names):
            self._pairs = list(zip(_POSITIVE, _NEGATIVE, strict=True))[: len(names)]
        if len(self._pairs) < len(names):
            what = f"at most {len(_POSITIVE)} joints to drive by keys"
            raise ConfigError(expected("keyboard", what, len(names)))
        self._came_s: dict[str, float] = {}
        self._space_s = -math.inf
        self._escape, self._escape_s = "", -math.inf  # of which letters are still to come
        self.help = _help(names, self._pairs)

    def press(self, letter: str, now_s: float) -> None:
        """A letter came: a key, pressed or repeated, or a part of one that is none of these.

        Arrows and the like come as several: an escape, then others that end with a letter.
        """
        if now_s - self._escape_s > ESCAPE_S:  # the escape key alone
            self._escape = ""
        if letter == _ESCAPE or self._escape:
            self._clutch = self._clutch and letter != " "  # whatever it is, it does not drive on
            self._escape, self._escape_s = _going_on(self._escape, letter), now_s
            return
        key = letter.lower()
        if key == " ":
            self._clutch = not self._clutch and now_s - self._space_s > AGAIN_S
            self._space_s = now_s
        elif key in "+=":
            self._speed = min(1.0, self._speed * SPEED_STEP)
        elif key in "-_":
            self._speed = max(SLOWEST, self._speed / SPEED_STEP)
        elif key in _WISHES:
            self._wish, self._clutch = _WISHES[key], False
        else:
            self._came_s[key] = now_s

    def let_out(self) -> None:
        """The clutch, until it is let in again."""
        self._clutch = False

    def read(self, now_s: float) -> Deflection:
        """As `InputDevice.read`; a wish is told once."""
        held = {key for key, came_s in self._came_s.items() if now_s - came_s <= HELD_S}
        wish, self._wish = self._wish, _NONE
        return Deflection(
            axes=tuple(float(up in held) - float(down in held) for up, down in self._pairs),
            grip=sum(_GRIP[key] for key in held & _GRIP.keys()),
            clutch=self._clutch,
            speed=self._speed,
            age_s=min((now_s - self._came_s[key] for key in held), default=0.0),
            wish=wish,
        )


_NONE: Wish = ""


def _going_on(escape: str, letter: str) -> str:
    """What has come of an escape sequence; "" once it is whole (ECMA-48, and SS3)."""
    if letter == _ESCAPE:
        return letter
    if escape == _ESCAPE:
        return escape + letter if letter in "[O" else ""
    is_first = escape == _ESCAPE + "[" and letter == "["  # F1 of a Linux console
    return "" if "@" <= letter <= "~" and not is_first else escape + letter


def _help(names: tuple[str, ...], pairs: list[tuple[str, str]]) -> str:
    axes = ", ".join(f"{up}/{down} {name}" for name, (up, down) in zip(names, pairs, strict=True))
    moves = f"{axes}; v/c gripper up/down its range; " if names else ""
    return f"space: clutch on/off; {moves}+/- speed; b give back; x or Ctrl-C end"


class Keyboard:
    """The keys of the terminal on standard input, unechoed and at once while its block lasts.

    Raises:
        ConfigError: standard input is no terminal.
        ServiceError: from `read`: the terminal is gone.
    """

    silence_s = HELD_S

    def __init__(self, keys: Keys) -> None:
        if not sys.stdin.isatty():
            raise ConfigError(expected("keyboard", "a terminal on standard input", "none"))
        self._keys, self._file = keys, sys.stdin.fileno()
        self._before = termios.tcgetattr(self._file)

    def __enter__(self) -> Keyboard:
        tty.setcbreak(self._file)
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(termios.error):  # the terminal is gone
            termios.tcsetattr(self._file, termios.TCSADRAIN, self._before)

    @property
    def help(self) -> str:
        """Which key does what."""
        return self._keys.help

    def let_out(self) -> None:
        """The clutch, until it is let in again."""
        self._keys.let_out()

    def read(self, now_s: float, at: FloatArray) -> Deflection:
        """As `InputDevice.read`."""
        while select.select([self._file], [], [], 0)[0]:
            try:
                came = os.read(self._file, 256)
            except OSError:
                came = b""
            if not came:
                raise ServiceError("keyboard: the terminal is gone; the robot holds")
            for letter in came.decode("ascii", errors="ignore"):
                self._keys.press(letter, now_s)
        return self._keys.read(now_s)
