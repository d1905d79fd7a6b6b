"""Whether results can be written, found out before the work that makes them; and why not."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from pathlib import Path

from fairlead.errors import ConfigError

BLOCK = 4096
"""Bytes, what file systems give out at once."""


def require_writable(who: str, path: Path) -> None:
    """Refuse a file or folder that cannot be made or written now. Makes nothing.

    Raises:
        ConfigError: saying why.
    """
    try:
        if path.is_file():
            with path.open("ab"):
                pass
        with tempfile.TemporaryFile(dir=_nearest_folder(path)) as probe:
            probe.write(bytes(BLOCK))  # a full disk may take a new file, but nothing in it
    except OSError as error:
        raise not_written(who, path, error) from None


def not_written(who: str, path: Path, error: OSError) -> ConfigError:
    """What to say of an error while writing it; of a full disk also how much room is left."""
    reason = os.strerror(error.errno) if error.errno else str(error)  # without a library's words
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        reason += f" ({room(path)})"
    return ConfigError(f"{who}: cannot write to {path}: {reason}")


def room(path: Path) -> str:
    """What to say of the disk on which a file or folder is, or would be."""
    free = shutil.disk_usage(_nearest_folder(path)).free
    return f"{free / 1e6:.1f} MB are free there"


def _nearest_folder(path: Path) -> Path:
    """The one it is in, or the innermost of those that are there already."""
    absolute = path.absolute()
    places = (absolute, *absolute.parents)
    return next(one for one in places if one.exists() and not (one == absolute and one.is_file()))
