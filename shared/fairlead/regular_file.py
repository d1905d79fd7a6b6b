"""Files that are read whole: no pipe or device, whose reading might never end."""

from __future__ import annotations

import errno
import stat
from pathlib import Path


def regular(path: Path) -> Path:
    """The path again, to read it now: of a regular file, or a link to one.

    Raises:
        OSError: it is something else, or cannot be seen; ``strerror`` says so in words.
    """
    mode = path.stat().st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):  # reading a folder says so itself
        raise OSError(errno.EINVAL, "a pipe or a device, not a file", str(path))
    return path
