"""Standard output that cannot be written: a full disk, a reader that has gone."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def forget_output() -> None:
    """What could not be written is not tried again at exit: that would be another error."""
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())
