"""A command in a terminal of its own: keys go in, what it shows comes out."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import threading
from collections.abc import Callable, Mapping, Sequence

from bench.equipment.live_robot import wait_for

REPEAT_S = 0.03
END_S = 20.0


class Terminal:
    """A command whose terminal is the other end of a pseudo-terminal.

    Attributes:
        output: what it has shown, from the text on that was waited for last.
    """

    def __init__(self, command: Sequence[str], environment: Mapping[str, str]) -> None:
        self._here, there = pty.openpty()
        self.process = subprocess.Popen(
            ["setsid", "--ctty", *command],
            env=environment,
            stdin=there,
            stdout=there,
            stderr=there,
        )
        os.close(there)
        self.output = ""
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        while True:
            try:
                came = os.read(self._here, 65536)
            except OSError:
                return
            self.output += came.decode(errors="replace")

    def wait_for(self, text: str) -> None:
        """Until it shows this, anew."""
        self.until(lambda: text in self.output, f"it shows {text!r}")
        self.output = self.output.rpartition(text)[2]

    def until(self, condition: Callable[[], bool], what: str) -> None:
        """Until something has happened; a failure says what it shows."""
        try:
            wait_for(condition, what)
        except AssertionError as error:
            raise AssertionError(f"{error}; it shows {self.output!r}") from None

    def press(self, keys: str) -> None:
        """Type."""
        os.write(self._here, keys.encode())

    def hold(self, key: str, until: Callable[[], bool], what: str) -> None:
        """Hold a key, as a terminal repeats it, until something has happened."""
        pause = threading.Event()

        def pressed() -> bool:
            self.press(key)
            pause.wait(REPEAT_S)
            return until()

        self.until(pressed, what)

    def hang_up(self) -> None:
        """The terminal's window is closed."""
        os.close(self._here)

    def ended(self) -> int:
        """Its exit status."""
        return self.process.wait(END_S)

    def end(self) -> None:
        """Ctrl-C, if it has not ended."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            self.ended()
