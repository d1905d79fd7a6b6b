"""``fairlead --version``: which fairlead, which gate and which tree of data a command would use."""

from __future__ import annotations

import hashlib
import platform
from importlib.metadata import PackageNotFoundError, version

import typer

from fairlead.cli.console import echo
from fairlead.errors import ConfigError
from fairlead.paths import gate_binary, repo_root

PACKAGES = ("eclipse-zenoh", "mujoco", "pin", "robosuite")


def print_version(wanted: bool) -> None:
    """Print it and end, if asked to."""
    if wanted:
        echo(version_text())
        raise typer.Exit


def version_text() -> str:
    """One line each for fairlead, its tree, its gate and what they run on."""
    packages = ", ".join(f"{name} {_installed(name)}" for name in PACKAGES)
    return (
        f"fairlead {version('fairlead')}\n"
        f"  tree: {repo_root()}\n"
        f"  gate: {_gate()}\n"
        f"  with: Python {platform.python_version()}, {packages}"
    )


def _gate() -> str:
    """The gate has no number of its own: its file's hash tells one build from another."""
    try:
        path = gate_binary()
    except ConfigError as error:
        return f"none ({error})"
    return f"{path}, SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()[:16]}"


def _installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
