"""The file that a service's lines are appended to."""

from __future__ import annotations

from pathlib import Path
from typing import IO


class ServiceLog:
    """Appends lines; where the disk takes none, lines are lost and nothing else is.

    Opened anew after a line was lost, so it goes on once there is room.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
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
