"""Every command of ``fairlead``, put together, and ``fairlead --version``."""

from __future__ import annotations

import hashlib
import platform
from importlib.metadata import PackageNotFoundError, version
from typing import Annotated

import typer

from fairlead.errors import ConfigError
from fairlead.paths import gate_binary, repo_root
from fairlead.plugins import DATA, HALS, LAYOUTS, POLICIES
from fairlead_tools.cli.acl import group as acl_group
from fairlead_tools.cli.arming import arm_command, disarm_command, reset_command, stop_command
from fairlead_tools.cli.bridge import group as bridge_group
from fairlead_tools.cli.calibrate import group as calibrate_group
from fairlead_tools.cli.certs import group as certs_group
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.demo import demo_command, plot_command
from fairlead_tools.cli.deploy import group as deploy_group
from fairlead_tools.cli.emulate import group as emulate_group
from fairlead_tools.cli.evaluate import eval_command
from fairlead_tools.cli.goals import cancel_command, episode_command, run_command
from fairlead_tools.cli.hal_check import group as hal_group
from fairlead_tools.cli.jog import home_command, jog_command
from fairlead_tools.cli.layout import group as layout_group
from fairlead_tools.cli.learn import dataset_group, export_group, train_command
from fairlead_tools.cli.options import EXIT_CODES, add_commands
from fairlead_tools.cli.parity import parity_command
from fairlead_tools.cli.processes import down_command, logs_command, ps_command
from fairlead_tools.cli.robot import group as robot_group
from fairlead_tools.cli.serve_policy import serve_policy_command
from fairlead_tools.cli.service import one_service_command, restart_command, router_command
from fairlead_tools.cli.skill import group as skill_group
from fairlead_tools.cli.status import status_command
from fairlead_tools.cli.teleop import teleop_command
from fairlead_tools.cli.topic import group as topic_group
from fairlead_tools.cli.up import up_command
from fairlead_tools.cli.why import judge_command, why_command

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


app = typer.Typer(
    name="fairlead",
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


add_commands(
    app,
    {
        "up": up_command,
        "down": down_command,
        "service": one_service_command,
        "restart": restart_command,
        "ps": ps_command,
        "logs": logs_command,
        "run": run_command,
        "cancel": cancel_command,
        "teleop": teleop_command,
        "jog": jog_command,
        "home": home_command,
        "episode": episode_command,
        "eval": eval_command,
        "train": train_command,
        "serve-policy": serve_policy_command,
        "arm": arm_command,
        "disarm": disarm_command,
        "stop": stop_command,
        "reset": reset_command,
        "status": status_command,
        "why": why_command,
        "judge": judge_command,
        "plot": plot_command,
        "parity": parity_command,
        "demo": demo_command,
        "router": router_command,
    },
)
for _group in (
    skill_group,
    robot_group,
    hal_group,
    layout_group,
    topic_group,
    acl_group,
    certs_group,
    deploy_group,
    calibrate_group,
    bridge_group,
    emulate_group,
    dataset_group,
    export_group,
):
    app.add_typer(_group)
