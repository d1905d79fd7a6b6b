"""``fairlead arm``, ``disarm``, ``stop``, ``reset``: what the gate grants, and ends."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.registry import Registry, running_name
from fairlead.errors import ConfigError, FairleadError, RefusedError
from fairlead.messages import ArmReply, GateState, GateStatus
from fairlead.operate.asker import OPERATOR_VARIABLE, check_person
from fairlead.operate.client import SEEN_S, RobotClient
from fairlead.operate.connection import connect, running_files
from fairlead_tools.cli.console import echo, hex_id
from fairlead_tools.cli.options import DeploymentOption, choose_deployment, example

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
    """Arm unless armed already; whoever armed disarms, if no other claim is live then.

    Where the way out of it is an error, that one is raised, also if disarming fails then.
    """
    before = client.gate_status()
    if before.state == GateState.ARMED:
        yield
        return
    try:
        arm_after_asking(client, before, confirmed)
        yield
    except BaseException:  # Ctrl-C while it arms, too: the gate may have heard it
        try:
            _disarm_unclaimed(client)
        except FairleadError as error:
            echo(f"not disarmed: {error}", err=True)
        raise
    _disarm_unclaimed(client)


def _disarm_unclaimed(client: RobotClient) -> None:
    """Unless somebody's goal runs, which has not claimed yet: the gate disarms when it is idle.

    The claim of a runner that has died ends within its heartbeats, and is nobody's.
    """
    status = client.status(timeout_s=SEEN_S)
    gate = status.gate or client.gate_status()
    if gate.state != GateState.ARMED or {one.source for one in gate.claims} - {*status.missing}:
        return
    if not any(goal.is_running for goal in status.runners):
        client.disarm()


@example("fairlead arm")
def arm_command(deployment: DeploymentOption = None, yes: YesOption = False) -> None:
    """Arm the gate: a new epoch starts, runners may claim parts of the robot.

    With profile `hardware` it asks first; where nobody can answer it refuses, but with --yes.
    """
    chosen = choose_deployment(deployment)
    with RobotClient(chosen) as client:
        reply = arm_after_asking(client, client.gate_status(), yes)
    echo(f"armed {chosen.id}: epoch {hex_id(reply.epoch)}")


@example("fairlead disarm")
def disarm_command(deployment: DeploymentOption = None) -> None:
    """Disarm the gate: every claim ends, the robot holds; goals that ran fail visibly."""
    chosen = choose_deployment(deployment)
    with RobotClient(chosen) as client:
        reply = client.disarm()
    echo(reply.text or f"disarmed {chosen.id}")


@example('fairlead stop --reason "hand in the cell"')
def stop_command(
    deployment: DeploymentOption = None,
    reason: Annotated[str, typer.Option(help="why, for the log")] = "operator",
) -> None:
    """Request a protective stop: a controlled standstill until its id is reset.

    Without --deployment of every robot that runs on this machine. This is not an emergency
    stop: use the robot's own for that.
    """
    files = [deployment] if deployment is not None else running_files()
    try:
        check_person()
    except ConfigError as error:  # no reason not to stop
        del os.environ[OPERATOR_VARIABLE]
        echo(f"WARNING {error}; stopping all the same", err=True)
    outcomes = asyncio.run(_stop_all(files, reason))
    failed = False
    for file, outcome in zip(files, outcomes, strict=True):
        if isinstance(outcome, BaseException):
            failed = True
            echo(f"ERROR {file}: NOT STOPPED: {outcome}", err=True)
            continue
        robot, stop_id = outcome
        which = f" --deployment {file}" if len(files) > 1 else ""
        echo(f"stopped {robot}; when it is safe: fairlead reset {hex_id(stop_id)}{which}")
    if failed:
        raise typer.Exit(1)


async def _stop_all(files: list[Path], reason: str) -> list[tuple[str, int] | BaseException]:
    """At once: nobody's stop waits for another's, or fails with it."""
    return await asyncio.gather(*(_stop(file, reason) for file in files), return_exceptions=True)


async def _stop(file: Path, reason: str) -> tuple[str, int]:
    chosen = _load_as_started(file)
    async with connect(chosen, by="fairlead") as robot:
        return running_name(chosen), await robot.stop(reason)


def _load_as_started(file: Path) -> Deployment:
    """The deployment; where its file cannot be read any more, as it was when it was started."""
    try:
        return load_deployment(file)
    except ConfigError:
        kept = Registry().kept_file(file)
        if kept is None:
            raise
        return load_deployment(kept)


_HIGHEST_ID = 2**64 - 1


def parse_id(text: str) -> int:
    """A stop's or latch's id, written in hex as `fairlead status` prints it."""
    try:
        number = int(text, 16)
    except ValueError:
        number = 0
    if not 0 < number <= _HIGHEST_ID:
        raise typer.BadParameter(
            f"expected 1 to 16 hex digits as printed by `fairlead status`, got {text!r}"
        )
    return number


@example("fairlead reset 5f0c3a9e12d4b687")
def reset_command(
    acknowledged: Annotated[
        int, typer.Argument(parser=parse_id, metavar="ID", help="the stop or latch id")
    ],
    deployment: DeploymentOption = None,
) -> None:
    """Acknowledge one stop or latch by its id; leads to disarmed, never to motion."""
    chosen = choose_deployment(deployment)
    with RobotClient(chosen) as client:
        reply = client.reset(acknowledged)
        left = client.gate_status()
    echo(reply.text or f"reset {chosen.id}")
    echo(f"next: {left.fix or 'fairlead arm'}")
