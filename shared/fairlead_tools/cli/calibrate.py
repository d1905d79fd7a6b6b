"""``fairlead calibrate``: what an arm's servos read where its joints are."""

from __future__ import annotations

import select
import sys
from typing import Annotated

import typer

from fairlead.errors import ConfigError
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.options import example, make_group

MOMENT_S = 0.02
"""Joints are followed this often: half a turn in it would be lost."""


@example("fairlead calibrate so101 --port /dev/ttyACM0")
def so101_command(
    port: Annotated[str, typer.Option(help="the arm's serial port")],
    name: Annotated[
        str, typer.Option(help="of the calibration, as in a deployment file; or a path to a file")
    ] = "so101",
) -> None:
    """Calibrate an SO-101: you move each joint by hand to both ends of its range.

    The arm goes limp: hold it. Homing offset and range are written into the servos, and with the
    direction into a file of yours. A joint that was not moved from end to end ends it: no file is
    written then.
    """
    from fairlead_hal_so101 import calibrate

    robot = load_robot("so101")
    echo("the arm goes limp: hold it")
    path = calibrate(robot, port, name, echo, _pressed)
    echo(f"wrote {path} and the servos; in the deployment file: calibration: {name}")


def _pressed() -> bool:
    """Whether a person has pressed Enter, after a moment.

    Raises:
        ConfigError: nobody can: the input has ended.
    """
    if not select.select([sys.stdin], [], [], MOMENT_S)[0]:
        return False
    if not sys.stdin.readline():
        raise ConfigError("calibrate: expected a person who presses Enter, got the end of input")
    return True


group = make_group(
    "calibrate",
    "Find out what an arm's servos read where its joints are.",
    {"so101": so101_command},
)
