"""What commands print: documents, ids, small tables, a line of progress; how Ctrl-C ends them."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, TextIO

from fairlead.wire.printable import printable, printable_lines


def echo(text: str, err: bool = False) -> None:
    """Lines for a person: what others wrote in them cannot move the cursor or colour the terminal.

    All of a command's words go through here.
    """
    print(printable_lines(text), file=sys.stderr if err else sys.stdout, flush=True)


def print_json(document: Any) -> None:
    """One JSON document on standard output."""
    print(json.dumps(document, indent=2, sort_keys=False), flush=True)


def hex_id(number: int) -> str:
    """An id as people read and type it; 0 means none."""
    return f"{number:016x}" if number else "none"


def print_table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Columns as wide as their content, two blanks between them."""
    lines = [list(header)] + [[printable(str(cell)) for cell in row] for row in rows]
    widths = [max(len(line[column]) for line in lines) for column in range(len(header))]
    for line in lines:
        cells = [cell.ljust(width) for cell, width in zip(line, widths, strict=True)]
        echo("  ".join(cells).rstrip())


def has_cursor(stream: TextIO) -> bool:
    """Whether what was printed can be written over: no file, and no terminal like Emacs' shell."""
    return stream.isatty() and os.environ.get("TERM", "dumb") != "dumb"


LINE_EVERY_S = 2.0  # in a log file
WORD_EVERY_S = 5.0


class ProgressLine:
    """Where progress is shown; on standard error, so that output can be piped."""

    def __init__(self, quiet: bool = False) -> None:
        self._quiet = quiet
        self._on_terminal = has_cursor(sys.stderr)
        self._last_s = -LINE_EVERY_S
        self._text = self._printed = ""

    def __enter__(self) -> ProgressLine:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def show(self, text: str) -> None:
        """Replace the line on a terminal; elsewhere print it now and then."""
        self._text = text = printable(text)
        if self._quiet:
            return
        if self._on_terminal:
            print(f"\r\x1b[2K{self._cut(text)}", end="", file=sys.stderr, flush=True)
        elif time.monotonic() - self._last_s >= LINE_EVERY_S:
            self._last_s, self._printed = time.monotonic(), text
            print(text, file=sys.stderr, flush=True)

    def say(self, text: str) -> None:
        """A line of its own, above what changes."""
        self.end()
        if not self._quiet:
            print(printable_lines(text), file=sys.stderr, flush=True)

    @contextmanager
    def counting(self) -> Iterator[Callable[[str], None]]:
        """For what may take minutes between two lines: what to show them with.

        Every `WORD_EVERY_S` in which no other comes, the newest is shown with the seconds it took.
        """
        newest, changed, over = "", threading.Event(), threading.Event()

        def show(text: str) -> None:
            nonlocal newest
            newest = text
            self.show(text)
            changed.set()

        def count() -> None:
            since_s = time.monotonic()
            while not over.is_set():
                if changed.wait(WORD_EVERY_S):
                    changed.clear()
                    since_s = time.monotonic()
                elif newest:
                    self.show(f"{newest} ({time.monotonic() - since_s:.0f} s)")

        thread = threading.Thread(target=count, daemon=True)
        thread.start()
        try:
            yield show
        finally:
            over.set()
            changed.set()
            thread.join()

    def end(self) -> None:
        """Leave the newest text, whole, as a line of its own."""
        if self._quiet or not self._text:
            return
        if self._text != self._printed:
            clear = "\r\x1b[2K" if self._on_terminal else ""
            print(f"{clear}{self._text}", file=sys.stderr, flush=True)
        self._text = ""

    @staticmethod
    def _cut(text: str) -> str:
        """What fits into the terminal's width: of a wrapped line only the last row is replaced."""
        width = os.get_terminal_size(sys.stderr.fileno()).columns or 80
        return text if len(text) < width else f"{text[: width - 2]}…"


def forget_output() -> None:
    """What could not be written is not tried again at exit: that would be another error."""
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


@contextmanager
def ends_like_ctrl_c() -> Iterator[None]:
    """A closed terminal and SIGTERM end the block as Ctrl-C does: what was begun is undone."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # in the background of a script
            signal.default_int_handler(number, frame)
        signal.raise_signal(signal.SIGINT)

    before = {one: signal.signal(one, interrupt) for one in (signal.SIGHUP, signal.SIGTERM)}
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
