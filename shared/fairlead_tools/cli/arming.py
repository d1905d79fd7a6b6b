"""Arming: a robot that is real is armed only by somebody who was asked and said yes."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from fairlead.errors import RefusedError
from fairlead.messages import ArmReply, GateState, GateStatus
from fairlead.operate.client import RobotClient

HARDWARE = "hardware"
YesOption = Annotated[bool, typer.Option("--yes", help="arm hardware without asking")]


def arm_after_asking(client: RobotClient, gate: GateStatus, confirmed: bool) -> ArmReply:
    """Arm; ask first where the deployment or the gate itself says that the robot is real.

    Raises:
        RefusedError: there is nobody to ask, or the gate says no.
        Abort: the answer was no.
    """
    if HARDWARE in (client.deployment.profile, gate.profile) and not confirmed:
        if not sys.stdin.isatty():
            reason = "the robot is real and will move, and there is no terminal to ask at"
            raise RefusedError("arm", reason, "add --yes, if people keep clear of it")
        typer.confirm("The robot is real and will move. Arm it?", abort=True)
    return client.arm()


@contextmanager
def armed(client: RobotClient, confirmed: bool = False) -> Iterator[None]:
    """Arm unless armed already; whoever armed disarms, if no other claim is live then."""
    before = client.gate_status()
    if before.state == GateState.ARMED:
        yield
        return
    arm_after_asking(client, before, confirmed)
    try:
        yield
    finally:
        gate = client.gate_status()
        if gate.state == GateState.ARMED and not gate.claims:
            client.disarm()
