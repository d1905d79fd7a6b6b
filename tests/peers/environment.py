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


VARIABLES = {
    "OPENPI": "CHECKOUT",
    "GROOT": "CHECKOUT[:CHECKOUT]",
    "RLDX": "CHECKOUT",
    "LEROBOT": "PYTHON",
}
"""The environment variables that name peers, and what each names."""

MARKERS = {
    "OPENPI": "src/openpi/serving/websocket_policy_server.py",
    "GROOT": "gr00t/policy/server_client.py",
    "RLDX": "rldx/policy/server_client.py",
}
"""By variable a file that must be in its checkouts."""

required: set[str] = set()
"""Variables of peers without which their tests fail (``--require``)."""


def named(variable: str) -> list[Path]:
    """What an environment variable names; nothing where it is not set."""
    text = os.environ.get(variable, "")
    return [Path(path).expanduser() for path in text.split(os.pathsep) if path]


def releases(variable: str) -> list[str]:
    """What an environment variable names, each with its commit or version."""
    return [f"{path} at {_release(variable, path)}" for path in named(variable)]


def _release(variable: str, path: Path) -> str:
    ask = ["git", "-C", str(path), "describe", "--always", "--dirty", "--exclude=*"]
    if variable == "LEROBOT":
        ask = [str(path), "-c", "import importlib.metadata as m; print(m.version('lerobot'))"]
    try:
        done = subprocess.run(ask, capture_output=True, text=True, check=False)
    except OSError as error:
        return f"no release: {error.strerror}"
    installed = [one.stem for one in path.glob(f"*{variable.lower()}-*.dist-info")]
    return done.stdout.strip() or "".join(installed) or "a commit that it does not tell"


def _demand(variable: str) -> list[Path]:
    found = named(variable)
    if not found:
        absent = f"{variable} names none: {variable}={VARIABLES[variable]} make peers"
        if variable in required:
            pytest.fail(absent)
        pytest.skip(absent)
    return found


def lerobot() -> str:
    """An interpreter that has lerobot.

    Skips the test where none is named, fails it where it is required.
    """
    [python] = _demand("LEROBOT")
    return str(python)


def by_lerobot(folder: Path, module: str, *arguments: str | Path) -> str:
    """What one of our modules prints there; folder: where lerobot may keep what it wants."""
    done = subprocess.run(
        [lerobot(), "-m", f"tests.peers.{module}", *arguments],
        cwd=repo_root(), capture_output=True, text=True, timeout=280,
        env=os.environ | {"HF_HUB_OFFLINE": "1", "HF_HOME": str(folder / "hf")},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def checkouts(variable: str) -> list[Path]:
    """The checkouts that an environment variable names.

    Skips the test where it is not set, fails it where it is required.
    """
    found = _demand(variable)
    for path in found:
        assert (path / MARKERS[variable]).exists(), f"{variable}: {path} has no {MARKERS[variable]}"
    return found
