"""Every command of ``fairlead``, put together, and ``fairlead --version``."""

from __future__ import annotations

import hashlib
import importlib
import platform
from collections.abc import Iterator, Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Annotated, Any

import typer
import typer.main
from typer.core import TyperCommand, TyperGroup

from fairlead.errors import ConfigError
from fairlead.paths import gate_binary, repo_root
from fairlead.plugins import DATA, HALS, LAYOUTS, POLICIES
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.options import EXIT_CODES, add_commands

COMMANDS = {
    "up": "up:up_command",
    "down": "processes:down_command",
    "service": "service:one_service_command",
    "restart": "service:restart_command",
    "ps": "processes:ps_command",
    "logs": "processes:logs_command",
    "run": "run:run_command",
    "cancel": "run:cancel_command",
    "teleop": "teleop:teleop_command",
    "jog": "jog:jog_command",
    "home": "jog:home_command",
    "episode": "episodes:episode_command",
    "eval": "evaluate:eval_command",
    "train": "learn:train_command",
    "serve-policy": "bridge:serve_policy_command",
    "arm": "arming:arm_command",
    "disarm": "arming:disarm_command",
    "stop": "arming:stop_command",
    "reset": "arming:reset_command",
    "status": "status:status_command",
    "why": "why:why_command",
    "judge": "why:judge_command",
    "plot": "demo:plot_command",
    "parity": "parity:parity_command",
    "demo": "demo:demo_command",
    "router": "service:router_command",
    "skill": "skill:group",
    "robot": "robot:group",
    "hal": "hal:group",
    "layout": "layout:group",
    "topic": "topic:group",
    "acl": "access:acl_group",
    "certs": "access:certs_group",
    "deploy": "deploy:group",
    "calibrate": "servos:calibrate_group",
    "bridge": "bridge:bridge_group",
    "emulate": "servos:emulate_group",
    "dataset": "learn:dataset_group",
    "export": "learn:export_group",
}
"""Where each is: a module beside this one, and what it is called there."""
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
        if not one.ships:
            added.setdefault(one.package, []).append(f"{one.what} {one.name}")
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


class _Commands(Mapping[str, TyperCommand | TyperGroup]):
    """Imports a command, or a group of them, when it is asked for: all together take a second."""

    def __getitem__(self, name: str) -> TyperCommand | TyperGroup:
        module, _, attribute = COMMANDS[name].partition(":")
        found = getattr(importlib.import_module(f"fairlead_tools.cli.{module}"), attribute)
        if isinstance(found, typer.Typer):
            return typer.main.get_group(found)
        only = typer.Typer(add_completion=False)
        add_commands(only, {name: found})
        command = typer.main.get_command(only)
        assert isinstance(command, TyperCommand)
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(COMMANDS)

    def __len__(self) -> int:
        return len(COMMANDS)


class _Root(TyperGroup):
    """``fairlead`` itself."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options | {"commands": _Commands()})

    def list_commands(self, ctx: object) -> list[str]:
        """Their names, none of them imported."""
        return list(COMMANDS)


app = typer.Typer(
    name="fairlead",
    cls=_Root,
    help="Run learned robot policies through typed commands and a C++ safety gate.",
    epilog=EXIT_CODES,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


@app.callback()
def _options(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=print_version,
            is_eager=True,
            help="Show which fairlead, gate and data this is, and exit.",
        ),
    ] = False,
) -> None:
    """Options of ``fairlead`` itself; the text of its help stands above."""
