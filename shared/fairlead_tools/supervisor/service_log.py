"""The file that a service's lines are appended to, and reading it while it grows."""

from __future__ import annotations

import os
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


class LogReader:
    """Reads a log of `ServiceLog`: its newest lines, then what is added, also once it is set aside.

    The file need not exist yet.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: IO[bytes] | None = None
        self._rest = b""

    def newest(self, count: int) -> list[str]:
        """The last ``count`` lines; `more` goes on from there."""
        lines = self.more()
        older = self._path.with_name(f"{self._path.name}.1")
        if len(lines) < count and older.exists():
            lines = [*_lines(older.read_bytes().removesuffix(b"\n").split(b"\n")), *lines]
        return lines[-count:]

    def more(self) -> list[str]:
        """The lines that came since the last call."""
        if self._file is None and not self._open():
            return []
        assert self._file is not None
        data = self._rest + self._file.read()
        while self._is_set_aside():
            data += self._file.read()
            self.close()
            if not self._open():
                break
            data += self._file.read()
        *whole, self._rest = data.split(b"\n")
        return _lines(whole)

    def close(self) -> None:
        """Close the file, if it is open."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _open(self) -> bool:
        try:
            self._file = self._path.open("rb")
        except FileNotFoundError:
            return False
        return True

    def _is_set_aside(self) -> bool:
        assert self._file is not None
        try:
            return not os.path.samestat(os.fstat(self._file.fileno()), self._path.stat())
        except FileNotFoundError:  # the next line begins it anew
            return True


def _lines(raw: list[bytes]) -> list[str]:
    return [line.decode(errors="replace") for line in raw]
