"""``fairlead calibrate``: what an arm's servos read where its joints are."""

from __future__ import annotations

import select
import sys
from typing import Annotated

import typer

from fairlead.errors import ConfigError, expected
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.options import example, make_group

MOMENT_S = 0.02
"""Joints are followed this often: half a turn in it would be lost."""


@example("fairlead calibrate so101 --port /dev/ttyACM0")
def so101_command(
    port: Annotated[str, typer.Option(help="the arm's serial port")],
    name: Annotated[
        str,
        typer.Option(
            help="of the calibration, as in a deployment file; or a path to a file; default: "
            "so101, of a leader so101_leader"
        ),
    ] = "",
    arm: Annotated[
        str, typer.Option(help="follower, or leader: an arm for fairlead teleop --device so101")
    ] = "follower",
) -> None:
    """Calibrate an SO-101: you move each joint by hand to both ends of its range.

    The arm goes limp: hold it. Homing offset and range are written into the servos, and with the
    direction into a file of yours. A joint that was not moved from end to end ends it: no file is
    written then. Of a leader the trigger stands for the jaw.
    """
    from fairlead_hal_so101 import calibrate

    if arm not in ("follower", "leader"):
        raise ConfigError(expected("calibrate: --arm", "an arm", repr(arm), ("follower", "leader")))
    is_leader = arm == "leader"
    name = name or ("so101_leader" if is_leader else "so101")
    robot = load_robot("so101")
    echo("the arm goes limp: hold it")
    path = calibrate(robot, port, name, echo, _pressed, "leader" if is_leader else "follower")
    used = f"--calibration {name}" if is_leader else f"in the deployment file: calibration: {name}"
    echo(f"wrote {path} and the servos; {used}")


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
