"""``fairlead emulate``: hardware that is not there, for tests and for a first look."""

from __future__ import annotations

import contextlib
import os
import selectors
import signal
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fairlead.errors import ConfigError
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.options import example, make_group

if TYPE_CHECKING:
    from fairlead_tools.emulate.orders import Emulated

IDLE_S = 0.005
"""The arm moves on at least this often."""

LinkOption = Annotated[
    Path | None,
    typer.Option(
        help="also a link to the port, for a deployment file's option port; gone at the end"
    ),
]


@example("fairlead emulate so101 --link /tmp/so101")
def so101_command(
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


group = make_group("emulate", "Stand in for hardware that is not there.", {"so101": so101_command})
