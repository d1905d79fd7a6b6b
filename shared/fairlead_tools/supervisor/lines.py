"""What a service prints, in lines: also where it ends none of them, or writes them over."""

from __future__ import annotations

LONGEST = 16 << 10
"""Bytes of a line that are kept."""


class Lines:
    r"""Cuts what was printed into lines, each as a terminal would show it in the end.

    So of a progress bar, which goes back to the line's beginning with ``\r``, the last state is
    kept. A line longer than `LONGEST` is cut, and says so.
    """

    def __init__(self) -> None:
        self._kept = bytearray()
        self._left_out = 0
        self._went_back = False

    def take(self, data: bytes) -> list[str]:
        """Take what came next.

        Returns:
            The lines that it ended, without what ended them and spaces before that.
        """
        *ends, rest = data.split(b"\n")
        lines = []
        for end in ends:
            self._add(end)
            lines.append(self._ended())
        self._add(rest)
        return lines

    def end(self) -> list[str]:
        """The last line, where it was not ended; else none."""
        return [self._ended()] if self._kept else []

    def _add(self, part: bytes) -> None:
        text = part.rstrip(b"\r")
        if text and (self._went_back or b"\r" in text):
            self._kept.clear()
            self._left_out = 0
            text = text.rpartition(b"\r")[2]
        room = LONGEST - len(self._kept)
        self._kept += text[:room]
        self._left_out += len(text[room:])
        if part:
            self._went_back = part.endswith(b"\r")

    def _ended(self) -> str:
        line = self._kept.decode(errors="replace").rstrip()
        if self._left_out:
            line += f" ... (cut: {self._left_out} bytes more)"
        self._kept.clear()
        self._left_out, self._went_back = 0, False
        return line
