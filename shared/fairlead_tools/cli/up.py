"""``fairlead up``: starts a deployment, watches it, ends it."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Annotated

import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.registry import Registry, running_name
from fairlead.deploy.stop_signals import ignore_further_signals
from fairlead.errors import FairleadError, each_error
from fairlead.messages import GateState
from fairlead.operate.connection import connect
from fairlead.operate.robot import Robot
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.options import (
    DeploymentArgument,
    NewStateOption,
    StateDirOption,
    WithoutOption,
    example,
    left_out,
)
from fairlead_tools.cli.up_output import (
    Greeting,
    OtherHosts,
    Say,
    UpOutput,
    explain_gate,
    wait_router,
)
from fairlead_tools.supervisor import ServiceEvent, Supervisor
from fairlead_tools.supervisor.before_start import checks, warning_lines
from fairlead_tools.supervisor.command_line import new_state_command, service_command
from fairlead_tools.supervisor.this_host import choose_host

READY_TIMEOUT_S = 120.0  # a first start compiles and caches much on a slow machine
WATCH_S = 0.1
WARN_AGAIN_S = 24 * 3600.0  # it runs for months, and certificates end
IN_BACKGROUND = "--in-background"
NO_READER = "what read these lines has gone, so it ends; what runs on without: fairlead up --detach"


@example("fairlead up panda_mobile_sim")
def up_command(
    deployment: DeploymentArgument,
    state_dir: StateDirOption = None,
    order: Annotated[str, typer.Option(help="start order, comma-separated; any order works")] = "",
    host: Annotated[
        str | None, typer.Option(help="which host of the file this machine is, if it has several")
    ] = None,
    without: WithoutOption = None,
    new_state: NewStateOption = False,
    detach: Annotated[
        bool,
        typer.Option(
            "--detach", help="return once what it starts is ready; it runs on until `down`"
        ),
    ] = False,
    in_background: Annotated[
        bool, typer.Option(IN_BACKGROUND, hidden=True, help="what --detach starts")
    ] = False,
) -> None:
    """Start a deployment's services (on one host), print their logs, restart what dies.

    It runs until Ctrl-C, or with --detach until `fairlead down`. A terminal that is closed or a
    pipe that nobody reads any more (| head -1) ends it as Ctrl-C does. A deployment of several
    hosts is started once on each, with --host, in any order.
    """
    loaded = load_deployment(deployment)
    _ = loaded.hal, loaded.only("safety")  # refused before a start
    host = choose_host(loaded, host)
    name = running_name(loaded, host)
    if detach:
        words = [IN_BACKGROUND if word == "--detach" else word for word in sys.argv[1:]]
        start_in_background(words, name)
        return
    os.umask(0o077)  # what robots do is nobody else's to read
    folder = state_dir or Registry().default_state_dir(name)
    say = UpOutput(folder)
    supervisor = Supervisor(
        deployment,
        loaded,
        folder,
        on_line=say,
        command=new_state_command() if new_state else service_command,
        host=host,
        leave_out=left_out(loaded, without),
    )
    try:
        _check(deployment, supervisor, say)
        asyncio.run(_run(supervisor, [one for one in order.split(",") if one], say, in_background))
    finally:
        ignore_further_signals()
        say.close()


def _check(file: Path, supervisor: Supervisor, say: Say) -> None:
    """Refuse what cannot work before anything is started; say which skills are left out."""
    for check in checks(file, supervisor.deployment, supervisor.processes):
        for line in check():
            say("up", line)


async def _run(supervisor: Supervisor, order: list[str], say: UpOutput, detach: bool) -> None:
    """Start and watch until a signal comes or something fails; then no process is left."""
    running = asyncio.create_task(_start_and_watch(supervisor, order, say, detach))
    asked = False  # `cancelling` counts what a timeout asks for, too

    def end() -> None:
        nonlocal asked
        if not asked:
            asked = True
            running.cancel()

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        asyncio.get_running_loop().add_signal_handler(number, end)
    await asyncio.wait({running})
    if say.has_lost_reader:
        say("up", NO_READER)
    failed = None if running.cancelled() else running.exception()
    try:
        killed = await supervisor.stop()
    except FairleadError as error:
        if failed is None:
            raise
        say("up", str(error))
    else:
        if killed:
            say("up", f"had to kill: {', '.join(killed)}")
    if failed is not None:
        raise failed
    say("up", f"stopped {supervisor.name}; no process is left")


async def _start_and_watch(
    supervisor: Supervisor, order: list[str], say: UpOutput, detach: bool
) -> None:
    gate, gate_is_back = supervisor.deployment.only("safety"), asyncio.Event()

    def tell(event: ServiceEvent) -> None:
        say("up", event.text)
        if event.kind == "ready" and event.service == gate:
            gate_is_back.set()

    supervisor.reserve()
    if ROUTER not in supervisor.processes:
        await wait_router(supervisor.deployment, say)
    await supervisor.start(order or None)
    try:
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(supervisor.keep(tell))
            await supervisor.wait_ready(READY_TIMEOUT_S)
            gate_is_back.clear()  # the greeting says how it is
            await _watch(supervisor, gate_is_back, say, detach)
    except ExceptionGroup as group:
        raise next(each_error(group)) from None


async def _watch(
    supervisor: Supervisor, gate_is_back: asyncio.Event, say: UpOutput, detach: bool
) -> None:
    """Greet; tell who is missing elsewhere, and why the gate will not arm; until cancelled."""
    async with connect(supervisor.deployment, by="fairlead up") as robot:
        others = OtherHosts(robot, supervisor.processes, say)
        greeting = Greeting(robot, supervisor.state_dir, say)
        warned_s = time.monotonic()
        try:
            while True:
                if gate_is_back.is_set():
                    gate_is_back.clear()
                    await _explain(robot, say)
                is_up = others.are_there() and await greeting.say_once_up()
                if detach and (is_up or others.said_missing or greeting.fault):
                    say.detach()
                    detach = False
                if time.monotonic() - warned_s > WARN_AGAIN_S:
                    warned_s = time.monotonic()
                    for line in warning_lines(supervisor.deployment):
                        say("up", line)
                await asyncio.sleep(WATCH_S)
        finally:
            if robot.gate in supervisor.processes:
                await disarm_to_the_end(robot, say)


async def _explain(robot: Robot, say: Say) -> None:
    try:
        explain_gate(await robot.gate_status(), say)
    except FairleadError as error:
        say("up", f"the gate does not answer yet: {error}")


async def disarm_to_the_end(robot: Robot, say: Say) -> None:
    """End claims before the processes, so that the gate's end is a clean one.

    Not broken off by Ctrl-C: that would be raised in the place of the error that ends `up`.
    """
    disarming = asyncio.ensure_future(_disarm(robot, say))
    while not disarming.done():
        with suppress(asyncio.CancelledError):
            await asyncio.wait({disarming})
    disarming.result()


async def _disarm(robot: Robot, say: Say) -> None:
    try:
        if (await robot.gate_status()).state == GateState.ARMED:
            await robot.disarm()
    except FairleadError as error:
        say("up", f"could not disarm before stopping: {error}")


END_TIMEOUT_S = 15.0


def start_in_background(words: Sequence[str], name: str) -> None:
    """Run ``fairlead`` with ``words``, print what it says until it is ready, and leave it running.

    It is ready when it closes its output. Ctrl-C before that ends it.

    Raises:
        typer.Exit: it ended instead, having said why.
    """
    command = [sys.executable, "-m", "fairlead_tools.cli.main", *words]
    process = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, start_new_session=True
    )
    assert process.stdout is not None
    try:
        _show(process.stdout)
    except KeyboardInterrupt:
        process.terminate()
        _show(process.stdout)
        process.wait(END_TIMEOUT_S)
        raise
    entry = Registry().find(name)
    if entry is None or entry.supervisor is None or entry.supervisor.pid != process.pid:
        raise typer.Exit(process.wait(END_TIMEOUT_S) or 1)
    echo(f"it runs in the background; stop it: fairlead down {name}")
    echo(f"its lines: fairlead logs -f -d {name}")


def _show(stream: IO[bytes]) -> None:
    for line in stream:
        echo(line.decode(errors="replace").rstrip())
