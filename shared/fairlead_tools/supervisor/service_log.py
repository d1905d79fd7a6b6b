"""The file that a service's lines are appended to, and reading it while it grows."""

from __future__ import annotations

import os
from pathlib import Path
from typing import IO

from fairlead.line_writer import set_aside
from fairlead.regular_file import regular

MOST_BYTES = 32 << 20
"""That a file may have, and the one before it too."""
_BLOCK = 1 << 16  # bytes


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
            data = f"{line}\n".encode()
            written = os.fstat(self._file.fileno()).st_size
            if written and written + len(data) > self._most_bytes:
                self.close()
                set_aside(self._path)
                self._file = self._path.open("ab", buffering=0)
            self._file.write(data)
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
        """The last ``count`` lines, read from the end; `more` goes on from there."""
        if self._file is not None or self._open():
            assert self._file is not None
            _go_back(self._file, count)
        lines = self.more()
        older = self._path.with_name(f"{self._path.name}.1")
        if len(lines) < count and older.exists():
            with regular(older).open("rb") as file:
                _go_back(file, count)
                lines = [*_lines(file.read().removesuffix(b"\n").split(b"\n")), *lines]
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
            self._file = regular(self._path).open("rb")
        except FileNotFoundError:
            return False
        return True

    def _is_set_aside(self) -> bool:
        assert self._file is not None
        try:
            return not os.path.samestat(os.fstat(self._file.fileno()), self._path.stat())
        except FileNotFoundError:  # the next line begins it anew
            return True


def _go_back(file: IO[bytes], count: int) -> None:
    """To where the last ``count`` lines of a file begin, or its first."""
    begin, ends = file.seek(0, os.SEEK_END), count + 1  # the newline before them too
    while begin and ends:
        block_begin = max(0, begin - _BLOCK)
        file.seek(block_begin)
        block = file.read(begin - block_begin)
        at = len(block)
        while ends and (at := block.rfind(b"\n", 0, at)) >= 0:
            ends -= 1
        begin = block_begin + (0 if ends else at + 1)
    file.seek(begin)


def _lines(raw: list[bytes]) -> list[str]:
    return [line.decode(errors="replace") for line in raw]
