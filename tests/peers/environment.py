"""Where the peers are: their environment, and checkouts that a person names."""

from __future__ import annotations

import os
import subprocess
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


def lerobot() -> str:
    """An interpreter that has lerobot.

    Skips the test where none is named.
    """
    python = os.environ.get("LEROBOT", "")
    if not python:
        pytest.skip("LEROBOT names no interpreter with lerobot: LEROBOT=PATH make peers")
    return python


def by_lerobot(folder: Path, module: str, *arguments: str | Path) -> str:
    """What one of our modules prints there; folder: where lerobot may keep what it wants."""
    done = subprocess.run(
        [lerobot(), "-m", f"tests.peers.{module}", *arguments],
        cwd=repo_root(), capture_output=True, text=True, timeout=280,
        env=os.environ | {"HF_HUB_OFFLINE": "1", "HF_HOME": str(folder / "hf")},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


MARKERS = {
    "OPENPI": "src/openpi/serving/websocket_policy_server.py",
    "GROOT": "gr00t/policy/server_client.py",
    "RLDX": "rldx/policy/server_client.py",
}
"""By environment variable a file that must be in its checkouts."""


def checkouts(variable: str) -> list[Path]:
    """The checkouts that an environment variable names.

    Skips the test where it is not set.
    """
    named = os.environ.get(variable, "")
    if not named:
        pytest.skip(f"{variable} names no checkout: {variable}=PATH make peers")
    found = [Path(path).expanduser() for path in named.split(os.pathsep)]
    for path in found:
        assert (path / MARKERS[variable]).exists(), f"{variable}: {path} has no {MARKERS[variable]}"
    return found
