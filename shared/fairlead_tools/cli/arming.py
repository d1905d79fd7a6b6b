"""``fairlead arm``, ``disarm``, ``stop``, ``reset``: what the gate grants, and ends."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.registry import Registry, running_name
from fairlead.errors import ConfigError, FairleadError, RefusedError
from fairlead.messages import ArmReply, GateState, GateStatus
from fairlead.operate.asker import OPERATOR_VARIABLE, person_here
from fairlead.operate.client import SEEN_S, RobotClient
from fairlead.operate.connection import choose_file, connect, running_files
from fairlead.operate.protective_stop import NO_REASON
from fairlead_tools.cli.console import echo, hex_id
from fairlead_tools.cli.options import DeploymentOption, choose_deployment, example, naming

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
        typer.confirm("The robot is real and will move. Arm it?", abort=True, err=True)
    return client.arm()


@contextmanager
def armed(client: RobotClient, confirmed: bool = False) -> Iterator[None]:
    """Arm unless armed already; whoever armed disarms, if no other claim is live then.

    So does whoever finds it armed by another run of the same command, before any goal: if that one
    is refused for this one's goal, nobody else would.
    Where the way out of it is an error, that one is raised, also if disarming fails then.
    """
    before = client.gate_status()
    is_armed = before.state == GateState.ARMED
    if is_armed and not (before.cause == f"armed by {client.by}" and _is_unused(client)):
        yield
        return
    may_be_ours = True
    try:
        try:
            if not is_armed:
                arm_after_asking(client, before, confirmed)
        except (RefusedError, typer.Abort):  # who is armed now, somebody else has armed
            may_be_ours = False
            raise
        yield
        _disarm_unclaimed(client)
    except BaseException as why:  # Ctrl-C while it arms or disarms, too: the gate may be armed
        try:
            if may_be_ours:
                _disarm_unclaimed(client)
        except FairleadError as error:
            if str(error) != str(why):
                echo(f"not disarmed: {error}", err=True)
        raise


def _disarm_unclaimed(client: RobotClient) -> None:
    if _is_unused(client):
        client.disarm()


def _is_unused(client: RobotClient) -> bool:
    """Whether it is armed, without a claim or somebody's goal, which has not claimed yet.

    The claim of a runner that has died ends within its heartbeats, and is nobody's. So is that of
    one without a goal: it was offered to the next one.
    """
    status = client.status(timeout_s=SEEN_S)
    gate = status.gate or client.gate_status()
    claimed = {one.source for one in gate.claims} - {*status.missing}
    if claimed:  # asked after the claims were seen: a goal that has begun since says so
        status = client.status(timeout_s=SEEN_S)
        claimed -= {goal.source for goal in status.runners if not goal.is_running}
    running = any(goal.is_running for goal in status.runners)
    return gate.state == GateState.ARMED and not claimed and not running


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
    reason: Annotated[str, typer.Option(help="why, for the log")] = NO_REASON,
) -> None:
    """Request a protective stop: a controlled standstill until its id is reset.

    Without --deployment of every robot that runs on this machine. This is not an emergency
    stop: use the robot's own for that.
    """
    files = [deployment] if deployment is not None else running_files()
    if not all(asyncio.run(_stop_all(files, reason))):
        raise typer.Exit(1)


async def _stop_all(files: list[Path], reason: str) -> list[bool]:
    """At once: nobody's stop waits for another's, or fails with it.

    A file may have been edited since, and started again: each robot is stopped as it was started.
    """
    told = [(file, kept) for file in files for kept in Registry().kept_files(file) or [file]]
    return await asyncio.gather(*(_stop(file, kept, reason) for file, kept in told))


async def _stop(file: Path, as_started: Path, reason: str) -> bool:
    """Whether it is stopped; said before the session ends, for which a hung service takes 10 s."""
    stopped = False
    try:
        chosen = _load_as_started(as_started, file)
        try:
            person_here(chosen)
        except ConfigError as error:  # no reason not to stop
            os.environ.pop(OPERATOR_VARIABLE)
            echo(f"WARNING {error}; stopping all the same", err=True)
        async with connect(chosen, by="fairlead") as robot:
            stop_id = hex_id(await robot.stop(reason))
            stopped = True
            reset = f"fairlead reset {stop_id}{naming(file)}"
            echo(f"stopped {running_name(chosen)}; when it is safe: {reset}")
    except Exception as error:  # noqa: BLE001 - of whatever kind: it is said, and the others stop
        if not stopped:
            echo(f"ERROR {file}: NOT STOPPED: {error}{_way_to_hold(file)}", err=True)
    return stopped


def _way_to_hold(file: Path) -> str:
    """What needs no link to the robot, where it runs on this machine."""
    here = [one.name for one in Registry().entries() if one.deployment == str(file.absolute())]
    ends = ", ".join(f"fairlead down {name}" for name in here)
    return f"; if no stop gets through: {ends} ends its services, and the robot holds" * bool(here)


def _load_as_started(kept: Path, file: Path) -> Deployment:
    with suppress(ConfigError):
        return load_deployment(kept)
    return load_deployment(file)


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
    echo(f"next: {left.fix or 'fairlead arm'}{naming(choose_file(deployment))}")
