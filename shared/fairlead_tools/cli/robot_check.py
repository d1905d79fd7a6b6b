"""``fairlead robot check``: what is consistent between a robot's files and its HAL."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.registry import Registry
from fairlead.errors import ConfigError, expected
from fairlead.messages import HalStatus
from fairlead.operate.client import RobotClient
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.options import (
    JsonOption,
    RobotArgument,
    example,
    parse_running_or_file,
)

if TYPE_CHECKING:
    from fairlead_tools.draft.robot_check import FrameRow


@example("fairlead robot check panda")
def check_command(
    robot: RobotArgument,
    deployment: Annotated[
        Path | None,
        typer.Option(
            "--deployment",
            "-d",
            parser=parse_running_or_file,
            metavar="NAME_OR_FILE",
            help="whose HAL to compare with; else the one that runs on this machine, if any",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Compare a robot's URDF, MJCF, capsules, gate files and HAL; what is missing, each with a fix.

    Exit code 1 if anything is missing or wrong; what is open is for a person to look at.
    """
    manifest = load_robot(robot)
    file = deployment or running_file(robot)
    hal = None if file is None else _running(manifest, file)
    from fairlead_tools.draft.robot_check import check_robot

    found = check_robot(manifest, hal)
    if as_json:
        document = dataclasses.asdict(found) | {"to_confirm": manifest.to_confirm}
        print_json({"robot": robot, "good": found.is_good, **document})
    else:
        if found.frames:
            _print_frames(found.frames)
        print_table(
            ("WHAT", "STATE", "FOUND", "FIX"),
            [(one.subject, one.state, _line(one.found), one.fix) for one in found.findings],
        )
    if not found.is_good:
        raise typer.Exit(1)


def _print_frames(frames: Sequence[FrameRow]) -> None:
    print_table(
        ("FRAME", "AT HOME [mm]", "[rad]", "RANDOM POSES [mm]", "[rad]"),
        [
            (one.frame, f"{one.home_mm:.3g}", f"{one.home_rad:.2g}",
             f"{one.random_mm:.3g}", f"{one.random_rad:.2g}")
            for one in frames
        ],
    )  # fmt: skip
    echo("")


def _line(text: str) -> str:
    first, *more = text.splitlines()
    return f"{first} ... (--json has all)" if more else first


def running_file(robot: str) -> Path | None:
    """The deployment file of a robot that runs on this machine, if one does."""
    files = [Path(entry.deployment) for entry in Registry().entries()]
    return next((one for one in files if load_deployment(one).robot == robot), None)


def running_robot() -> str | None:
    """The robot of the only deployment that runs on this machine."""
    try:
        robots = {load_deployment(Path(one.deployment)).robot for one in Registry().entries()}
    except ConfigError:  # its file has changed or gone since
        return None
    return robots.pop() if len(robots) == 1 else None


def _running(robot: RobotManifest, file: Path) -> HalStatus:
    deployment = load_deployment(file)
    if deployment.robot != robot.id:
        what = f"a deployment of {robot.id}"
        raise ConfigError(expected("robot check", what, f"one of {deployment.robot}"))
    with RobotClient(deployment) as client:
        return client.hal_status()
