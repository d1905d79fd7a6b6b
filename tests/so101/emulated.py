"""``fairlead emulate so101`` as a process of its own, and a line to it."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.cli.command import fairlead_command, fairlead_environment


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
def emulated_arm(folder: Path, *options: str) -> Iterator[EmulatedArm]:
    """An arm that stands ready until the end of the block."""
    folder.mkdir(exist_ok=True)
    port = folder / "so101"
    with subprocess.Popen(
        fairlead_command("emulate", "so101", "--link", str(port), *options),
        env=fairlead_environment(folder),
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
