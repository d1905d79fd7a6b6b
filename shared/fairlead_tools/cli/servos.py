"""``fairlead calibrate`` and ``emulate``: an arm's servos, and ones that are not there."""

from __future__ import annotations

import contextlib
import os
import select
import selectors
import signal
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fairlead.errors import ConfigError, expected
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.options import example, make_group

if TYPE_CHECKING:
    from fairlead_tools.emulate.orders import Emulated


MOMENT_S = 0.02
"""Joints are followed this often: half a turn in it would be lost."""


@example("fairlead calibrate so101 --port /dev/ttyACM0")
def calibrate_command(
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


calibrate_group = make_group(
    "calibrate",
    "Find out what an arm's servos read where its joints are.",
    {"so101": calibrate_command},
)


IDLE_S = 0.005
"""The arm moves on at least this often."""

LinkOption = Annotated[
    Path | None,
    typer.Option(
        help="also a link to the port, for a deployment file's option port; gone at the end"
    ),
]


@example("fairlead emulate so101 --link /tmp/so101")
def emulate_command(
    link: LinkOption = None,
    mounting: Annotated[
        int | None,
        typer.Option(help="a seed: horns mounted anyhow, so that the arm has to be calibrated"),
    ] = None,
    seed: Annotated[int, typer.Option(help="of what noise, lose and late leave to chance")] = 0,
) -> None:
    """Emulate an SO-101: six STS3215 servos on a serial port, an arm in MuJoCo that they move.

    Speaks the servos' protocol at 1 Mbit/s, half duplex. Lines typed here are faults and a
    person's hand: type help for a list. Ends with Ctrl-C or quit.
    """
    from fairlead_tools.emulate.orders import Emulated
    from fairlead_tools.emulate.servo_arm import ServoArm
    from fairlead_tools.emulate.servo_bus import ServoBus

    if hasattr(signal, "SIGTTIN"):  # in the background nobody types
        signal.signal(signal.SIGTTIN, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _interrupt)
    arm = ServoArm(load_robot("so101"), time.monotonic(), mounting)
    bus = ServoBus(arm.servos, arm.advance, seed)
    if link is not None:
        _link(link, bus.port)
    try:
        echo(f"so101: servos 1 to 6 on {link or bus.port}, 1 Mbit/s; type help, or quit")
        _serve(Emulated(arm, bus))
    except KeyboardInterrupt:
        pass
    finally:
        bus.close()
        if link is not None:
            link.unlink(missing_ok=True)


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def _link(link: Path, port: str) -> None:
    if link.is_symlink() and not link.exists():  # left by one that was killed
        link.unlink()
    try:
        link.symlink_to(port)
    except OSError as error:
        raise ConfigError(f"emulate: --link {link}: {error.strerror}") from None


def _serve(emulated: Emulated) -> None:
    """Until a person says quit."""
    typed = bytearray()
    with selectors.DefaultSelector() as waiting:
        waiting.register(emulated.bus, selectors.EVENT_READ)
        with contextlib.suppress(PermissionError, ValueError, OSError):  # a file: nobody types
            waiting.register(sys.stdin, selectors.EVENT_READ)
        while True:
            for key, _ in waiting.select(IDLE_S):
                if key.fileobj is emulated.bus:
                    emulated.bus.serve()
                    continue
                said = _typed()
                typed += said
                if not said:
                    waiting.unregister(sys.stdin)
            while b"\n" in typed:
                line, _, rest = typed.partition(b"\n")
                typed = bytearray(rest)
                if not _obey(emulated, line.decode(errors="replace").strip()):
                    return
            emulated.arm.advance(time.monotonic())


def _typed() -> bytes:
    try:
        return os.read(sys.stdin.fileno(), 4096)
    except OSError:  # in the background
        return b""


def _obey(emulated: Emulated, line: str) -> bool:
    """Carry out one line and say so; False: the end."""
    from fairlead_tools.emulate.orders import ORDERS, carry_out

    if line == "quit":
        return False
    if line == "help":
        echo("\n".join(f"  {order.usage:<24} {order.text}" for order in ORDERS.values()))
    elif line:
        try:
            echo(carry_out(emulated, line))
        except ConfigError as error:
            echo(f"ERROR {error}")
    return True


emulate_group = make_group(
    "emulate", "Stand in for hardware that is not there.", {"so101": emulate_command}
)
