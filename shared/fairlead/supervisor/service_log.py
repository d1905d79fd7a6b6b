"""The file that a service's lines are appended to."""

from __future__ import annotations

from pathlib import Path
from typing import IO

from fairlead.line_writer import set_aside

MOST_BYTES = 32 << 20
"""A file is full then: half of what it and the one before it may have."""


class ServiceLog:
    """Appends lines; where the disk takes none, lines are lost and nothing else is.

    Opened anew after a line was lost, so it goes on once there is room. A full file becomes
    ``<name>.1``, and what had that name goes.
    """

    def __init__(self, path: Path, most_bytes: int = MOST_BYTES) -> None:
        self._path, self._most_bytes = path, most_bytes
        self._file: IO[bytes] | None = None
        self._lost = 0

    def append(self, line: str) -> str:
        """Write one line.

        Returns:
            What a person should know: that lines are being lost, or were; else "".
        """
        try:
            if self._file is None:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                self._file = self._path.open("ab", buffering=0)  # no half line left for later
            self._file.write(f"{line}\n".encode())
            if self._file.tell() >= self._most_bytes:
                self.close()
                set_aside(self._path)
        except OSError as error:
            self.close()
            self._lost += 1
            return f"{self._path}: {error.strerror}; lines are lost" if self._lost == 1 else ""
        lost, self._lost = self._lost, 0
        return f"{self._path}: written again; {lost} lines were lost" if lost else ""

    def close(self) -> None:
        """Close the file, if it is open."""
        if self._file is not None:
            self._file.close()
            self._file = None
