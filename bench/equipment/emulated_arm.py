"""``fairlead emulate so101`` as a process of its own, and a line to it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


class EmulatedArm:
    """The emulator's port, and its orders."""

    def __init__(self, process: subprocess.Popen[str], port: Path) -> None:
        self.process, self.port = process, port

    def order(self, line: str) -> str:
        """Type a line; what it answers."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline().strip()


@contextmanager
def emulated_arm(folder: Path, *options: str, before: Sequence[str] = ()) -> Iterator[EmulatedArm]:
    """An arm that stands ready until the end of the block.

    Args:
        folder: gets a link to its port.
        options: of the command.
        before: words before the command.
    """
    folder.mkdir(exist_ok=True)
    port = folder / "so101"
    command = [sys.executable, "-m", "fairlead_tools.cli.main", "emulate", "so101"]
    with subprocess.Popen(
        [*before, *command, "--link", str(port), *options],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert f"servos 1 to 6 on {port}" in process.stdout.readline()
        try:
            yield EmulatedArm(process, port)
        finally:
            process.terminate()
