"""``fairlead --version``: which fairlead, which gate and which tree of data a command would use."""

from __future__ import annotations

import hashlib
import platform
from importlib.metadata import PackageNotFoundError, version

import typer

from fairlead.errors import ConfigError
from fairlead.paths import gate_binary, repo_root
from fairlead.plugins import DATA, HALS, LAYOUTS, POLICIES
from fairlead_tools.cli.console import echo

PACKAGES = ("eclipse-zenoh", "mujoco", "pin", "robosuite")


def print_version(wanted: bool) -> None:
    """Print it and end, if asked to."""
    if wanted:
        echo(version_text())
        raise typer.Exit


def version_text() -> str:
    """One line each for fairlead, its tree, its gate, what they run on and what others add."""
    packages = ", ".join(f"{name} {_installed(name)}" for name in PACKAGES)
    return (
        f"fairlead {version('fairlead')}\n"
        f"  tree: {repo_root()}\n"
        f"  gate: {_gate()}\n"
        f"  with: Python {platform.python_version()}, {packages}{_plug_ins()}"
    )


def _plug_ins() -> str:
    """A line for each other package that adds something, and what."""
    added: dict[str, list[str]] = {}
    for one in (one for group in (HALS, POLICIES, LAYOUTS, DATA) for one in group.every()):
        added.setdefault(one.package, []).append(f"{one.what} {one.name}")
    added.pop(f"fairlead {version('fairlead')}", None)
    return "".join(f"\n  {package}: {', '.join(what)}" for package, what in added.items())


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
