"""Programs of docs/examples that a person starts with words: without them, they say which."""

from __future__ import annotations

import subprocess
import sys

import pytest

from fairlead.paths import repo_root


@pytest.mark.processes
@pytest.mark.parametrize(
    ("program", "words"),
    [
        ("run_client", "deployment skill prompt"),
        ("go_to_client", "deployment x_m y_m yaw_rad"),
        ("localiser", "deployment name x_m y_m"),
    ],
)
def test_without_its_words_a_program_says_which(program: str, words: str) -> None:
    file = repo_root() / "docs" / "examples" / f"{program}.py"
    done = subprocess.run([sys.executable, str(file)], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines()[0] == f"usage: {program}.py [-h] {words}"
