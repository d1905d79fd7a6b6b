"""What a command that runs on says."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.cli.command import fairlead_command, fairlead_environment


@contextmanager
def running(tmp_path: Path, *words: str) -> Iterator[subprocess.Popen[str]]:
    """A command, asked to end at the end."""
    with subprocess.Popen(
        fairlead_command(*words), env=fairlead_environment(tmp_path), text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    ) as process:  # fmt: skip
        try:
            yield process
        finally:
            process.terminate()


def assert_says(process: subprocess.Popen[str], end: str) -> None:
    """Wait for a line with this end; the test's time ends if it never comes."""
    assert process.stdout is not None
    assert any(line.endswith(f"{end}\n") for line in process.stdout), f"ended without: {end}"
