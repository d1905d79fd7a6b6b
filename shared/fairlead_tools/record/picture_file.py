"""What a picture's file is called."""

from __future__ import annotations

from pathlib import Path

from fairlead.errors import ConfigError, expected

SUFFIXES = (".png", ".svg", ".pdf")


def require_picture(who: str, path: Path) -> None:
    """Refuse a name that says another format than those that can be drawn.

    Raises:
        ConfigError: naming those.
    """
    if path.suffix not in SUFFIXES:
        raise ConfigError(expected(who, "a file of a picture", repr(str(path)), SUFFIXES))
