"""What the gate has room for: what it would refuse at its start is refused at compile time."""

from __future__ import annotations

from fairlead.errors import ConfigError, expected
from fairlead.robot.gate_geometry import Json
from fairlead.robot.manifest import RobotManifest

MAX_SOURCE = 256
"""Bytes of a source that the gate keeps and cites."""
MAX_NAME = 64
_NAMES = ("name", "part", "link", "parent", "root", "tool_frame")
MAX_FRAMES = 4
"""Frames that a mode may be told in."""
MOST = {
    "joints": 32,
    "passive_joints": 16,
    "kinematics.links": 63,
    "parts": 8,
}


def check_capacity(robot: RobotManifest, config: dict[str, Json]) -> None:
    """Whether a compiled file fits into the gate.

    Raises:
        ConfigError: naming the place: a source or a name that the gate would cut, and so cite
            wrongly, a name that is none, a list that is too long.
    """
    _check(f"robot {robot.id}: gate file: ", "", "", config)


def _check(who: str, path: str, key: str, entry: Json) -> None:
    if isinstance(entry, dict):
        for name, value in entry.items():
            _check(who, f"{path}.{name}" if path else name, name, value)
    elif isinstance(entry, str):
        _check_text(f"{who}{path}", key, entry)
    elif isinstance(entry, list | tuple):
        most = MAX_FRAMES if key == "frames" else MOST.get(path, len(entry))
        if len(entry) > most:
            raise ConfigError(expected(f"{who}{path}", f"at most {most}", str(len(entry))))
        for index, value in enumerate(entry):
            _check(who, f"{path}[{index}]", "", value)


def _check_text(who: str, key: str, text: str) -> None:
    size = len(text.encode(errors="replace"))
    if not text.isprintable() and key == "source":
        raise ConfigError(expected(who, "text that can be printed, on one line", repr(text)))
    if key == "source" and size > MAX_SOURCE:
        raise ConfigError(expected(who, f"at most {MAX_SOURCE} bytes", f"{size}: {text!r}"))
    if key in _NAMES and not (0 < size <= MAX_NAME and text.isprintable() and text.strip()):
        wanted = f"a name of 1 to {MAX_NAME} bytes that can be printed"
        raise ConfigError(expected(who, wanted, repr(text)))
