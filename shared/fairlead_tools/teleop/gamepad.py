"""A gamepad as an input device: sticks drive while the right shoulder button is held.

Events are Linux's (evdev), as kernel drivers name the axes and buttons of a gamepad.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fairlead.errors import ConfigError, ServiceError, expected
from fairlead.messages import FloatArray
from fairlead_tools.teleop.device import Deflection, Wish

if TYPE_CHECKING:
    from evdev import InputDevice

SILENCE_S = 1.0
"""A stick in a hand trembles: one that is deflected and says nothing for so long is not held."""
DEAD_ZONE = 0.12
SPEED_STEP = 1.25
SLOWEST = 0.02

_SYN, _KEY, _ABS = 0, 1, 3  # event types
_DROPPED = (
    3  # of _SYN: the kernel's queue was full; what follows is told whole with the next report
)
_LEFT_X, _LEFT_Y, _LEFT_TRIGGER, _RIGHT_X, _RIGHT_Y, _RIGHT_TRIGGER = 0, 1, 2, 3, 4, 5
_HAT_X, _HAT_Y = 16, 17
_A, _B, _X, _Y, _RIGHT_SHOULDER, _SELECT, _START = 304, 305, 307, 308, 311, 314, 315
TRIGGERS = (_LEFT_TRIGGER, _RIGHT_TRIGGER)

Source = tuple[str, tuple[tuple[int, float], ...]]
"""What a person calls it, and which axes make it up, each with its sign."""
_UP_DOWN: Source = ("triggers", ((_RIGHT_TRIGGER, 1.0), (_LEFT_TRIGGER, -1.0)))
_ALONG: dict[str, Source] = {  # up and left are below zero on a gamepad
    "x": ("left stick up", ((_LEFT_Y, -1.0),)),
    "y": ("left stick left", ((_LEFT_X, -1.0),)),
    "z": _UP_DOWN,
    "rx": ("cross right", ((_HAT_X, 1.0),)),
    "ry": ("right stick up", ((_RIGHT_Y, -1.0),)),
    "rz": ("right stick left", ((_RIGHT_X, -1.0),)),
}
_JOINTS: tuple[Source, ...] = (
    ("left stick left", ((_LEFT_X, -1.0),)),
    ("left stick up", ((_LEFT_Y, -1.0),)),
    ("right stick up", ((_RIGHT_Y, -1.0),)),
    ("right stick left", ((_RIGHT_X, -1.0),)),
    _UP_DOWN,
    ("cross right", ((_HAT_X, 1.0),)),
    ("cross up", ((_HAT_Y, -1.0),)),
)


class Pad:
    """What a gamepad's events mean, without the gamepad.

    Args:
        names: axes of the drive, as in `Drive.names`.
        speed: share of full speed at the start.
        ranges: lowest and highest value of each axis of the gamepad.

    Raises:
        ConfigError: more joints than a gamepad has axes.
    """

    def __init__(
        self, names: tuple[str, ...], speed: float, ranges: Mapping[int, tuple[int, int]]
    ) -> None:
        along = [_ALONG[name] for name in names if name in _ALONG]
        self._sources = along if len(along) == len(names) else list(_JOINTS)[: len(names)]
        if len(self._sources) < len(names):
            what = f"at most {len(_JOINTS)} joints to drive"
            raise ConfigError(expected("gamepad", what, len(names)))
        self._ranges, self._speed = ranges, speed
        self._axes: dict[int, float] = {}
        self._down: set[int] = set()
        self._heard_s = 0.0
        self._is_dropping = False
        self._wish: Wish = ""
        axes = ", ".join(
            f"{said} {name}" for (said, _), name in zip(self._sources, names, strict=True)
        )
        self.help = (
            f"hold the right shoulder button: clutch; {axes}; B/A gripper up/down its range; "
            "Y/X speed; start gives back; select ends"
        )

    def event(self, kind: int, code: int, value: int, now_s: float) -> None:
        """One event, as the kernel's ``input_event`` has it."""
        if kind == _SYN:
            self._is_dropping = code == _DROPPED
            if self._is_dropping:  # a release may be among what was lost: nothing is held any more
                self._axes, self._down = {}, set()
        if kind == _SYN or self._is_dropping:
            return
        self._heard_s = now_s
        if kind == _ABS:
            self._axes[code] = self._share(code, value)
        elif kind == _KEY:
            self._down = self._down | {code} if value else self._down - {code}
            if value == 1:
                self._pressed(code)

    def read(self, now_s: float) -> Deflection:
        """As `InputDevice.read`; a wish is told once."""
        wish, self._wish = self._wish, _NONE
        return Deflection(
            axes=tuple(
                sum(sign * self._axes.get(code, 0.0) for code, sign in made)
                for _, made in self._sources
            ),
            grip=float(_B in self._down) - float(_A in self._down),
            clutch=_RIGHT_SHOULDER in self._down,
            speed=self._speed,
            age_s=now_s - self._heard_s,
            wish=wish,
        )

    def _pressed(self, code: int) -> None:
        if code == _START:
            self._wish = "give back"
        elif code == _SELECT:
            self._wish = "quit"
        elif code == _Y:
            self._speed = min(1.0, self._speed * SPEED_STEP)
        elif code == _X:
            self._speed = max(SLOWEST, self._speed / SPEED_STEP)

    def _share(self, code: int, value: int) -> float:
        """A stick's in [-1, 1], a trigger's in [0, 1]; nothing within the dead zone."""
        low, high = self._ranges.get(code, (-1, 1))
        share = (value - low) / max(high - low, 1)
        if code not in TRIGGERS:
            share = 2.0 * share - 1.0
        beyond = max(0.0, abs(share) - DEAD_ZONE) / (1.0 - DEAD_ZONE)
        return beyond if share > 0 else -beyond


_NONE: Wish = ""


class Gamepad:
    """A gamepad that Linux knows, read without waiting.

    Args:
        pad: what its events mean.
        device: of the library ``evdev``.
    """

    silence_s = SILENCE_S

    def __init__(self, pad: Pad, device: InputDevice[str]) -> None:
        self._pad, self._device = pad, device

    def __enter__(self) -> Gamepad:
        return self

    def __exit__(self, *_: object) -> None:
        self._device.close()

    @property
    def help(self) -> str:
        """Which stick and button does what."""
        return self._pad.help

    def read(self, now_s: float, at: FloatArray) -> Deflection:
        """As `InputDevice.read`.

        Raises:
            ServiceError: it was unplugged, or its link is lost.
        """
        try:
            while (event := self._device.read_one()) is not None:
                self._pad.event(event.type, event.code, event.value, now_s)
        except OSError as error:
            why = error.strerror or error
            raise ServiceError(f"gamepad: it is gone ({why}); the robot holds") from None
        return self._pad.read(now_s)


def open_gamepad(names: tuple[str, ...], speed: float, path: str = "") -> Gamepad:
    """The gamepad at a path such as /dev/input/event3; "": the first there is.

    Raises:
        ConfigError: the library is not installed, there is none, or it is no gamepad.
    """
    try:
        import evdev
    except ImportError:
        raise ConfigError(
            "gamepad: needs the package evdev; try: pip install evdev-binary"
        ) from None
    try:
        devices = [
            evdev.InputDevice(one)
            for one in ([path] if path else [str(one) for one in evdev.list_devices()])
        ]
    except OSError as error:
        raise ConfigError(f"gamepad: {path or error.filename}: {error.strerror}") from None
    for device in devices:
        found = device.capabilities(absinfo=False)
        if _A in found.get(_KEY, ()) and found.get(_ABS):
            infos = {code: device.absinfo(code) for code in found[_ABS]}
            ranges = {code: (info.min, info.max) for code, info in infos.items()}
            return Gamepad(Pad(names, speed, ranges), device)
    what = "a gamepad among the input devices that this user may read"
    valid = [str(one.path) for one in devices]
    raise ConfigError(expected("gamepad", what, path or "none", valid))
