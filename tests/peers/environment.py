"""Where the peers are: their environment, and checkouts that a person names."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from fairlead.paths import repo_root


def peer(module: str) -> list[str]:
    """A command that runs one of our modules with the published packages.

    Skips the test where they are not installed.
    """
    python = repo_root() / "build" / "peers" / "bin" / "python"
    if not python.exists():
        pytest.skip("the peers' packages are not installed: make peers")
    return [str(python), "-u", "-m", f"tests.peers.{module}"]


def checkouts(variable: str, marker: str) -> list[Path]:
    """The checkouts that an environment variable names, each with a file that must be in it.

    Skips the test where it is not set.
    """
    named = os.environ.get(variable, "")
    if not named:
        pytest.skip(f"{variable} names no checkout: {variable}=PATH make peers")
    found = [Path(path).expanduser() for path in named.split(os.pathsep)]
    for path in found:
        assert (path / marker).exists(), f"{variable}: {path} has no {marker}"
    return found
