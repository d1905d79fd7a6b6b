"""What every Python service's ``main`` does: arguments, event loop, session, clean end."""

from __future__ import annotations

import argparse
import asyncio
import gc
import logging
import threading
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from fairlead.deploy.access_warnings import warn_daily
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.peer_watch import watch_peers
from fairlead.deploy.router_watch import open_with_logging, refuse_duplicate_service, watch_router
from fairlead.deploy.service_manager import Pulse, say_alive, say_ready
from fairlead.deploy.stop_signals import StopSignals, ignore_further_signals
from fairlead.errors import FairleadError, each_error
from fairlead.log_output import LogOutput, flush_log
from fairlead.log_stamp import stamped
from fairlead.wire.lingering import forbid_lingering
from fairlead.wire.on_loop import QueryTasks
from fairlead.wire.session import ZenohBus

__all__ = ["ServiceContext", "announce_ready", "run_in_thread", "run_service"]

T = TypeVar("T")


@dataclass(frozen=True)
class ServiceContext:
    """What a service knows about itself when it starts.

    Attributes:
        name: the service's name in the deployment file; also its source in keys.
        options: its ``options`` block, still to be checked by the service.
        state_dir: an existing folder for this service's logs and state.
        stopping: set when the process was asked to end.
        tasks: of this service. One that raises ends the service; those that still run when the
            body has returned are cancelled.
        queries: answered by such tasks.
        started: `announce_ready` calls it; asked to end before, the process just ends.
        pulse: of a thread without which the service does nothing: systemd is told whether it goes
            on.
    """

    name: str
    deployment: Deployment
    options: dict[str, Any]
    state_dir: Path
    bus: ZenohBus
    stopping: asyncio.Event
    tasks: asyncio.TaskGroup
    queries: QueryTasks
    started: Callable[[], None]
    pulse: Pulse


Body = Callable[[ServiceContext], Awaitable[None]]


def run_service(who: str, body: Body) -> int:
    """Run ``body`` on an event loop until it returns; its ``stopping`` says when it should.

    Asked to stop (SIGTERM, SIGINT), or once the body has returned, the process ends within a few
    seconds even if something in it hangs (exit status 1 then). What blocks belongs in a thread
    (`run_in_thread`, ``asyncio.to_thread``): a loop that is held up hears no signal.

    Returns:
        The exit status: 0 on a clean end, 1 after an error that has been printed.
    """
    parser = argparse.ArgumentParser(
        prog=who, epilog=f"example: {who} --deployment FILE --service NAME --state-dir DIR"
    )
    parser.add_argument("--deployment", type=Path, required=True, help="file from compose/")
    parser.add_argument("--service", required=True, help="this service's name in that file")
    parser.add_argument("--state-dir", type=Path, required=True, help="folder for logs and state")
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.INFO, handlers=[LogOutput()])
    try:
        return asyncio.run(_serve(who, arguments, body))
    finally:
        ignore_further_signals()


async def _watch_links(
    tasks: asyncio.TaskGroup,
    bus: ZenohBus,
    deployment: Deployment,
    service: str,
    log: logging.Logger,
) -> None:
    if deployment.router is not None:
        await refuse_duplicate_service(service, bus, deployment.keys.alive(service))
        tasks.create_task(watch_router(bus, deployment.router_endpoint, log))
        tasks.create_task(forbid_lingering(deployment.router.port))
    elif not deployment.open_access:
        tasks.create_task(watch_peers(bus, deployment, service, log))


async def _serve(who: str, arguments: argparse.Namespace, body: Body) -> int:
    signals = StopSignals(who)
    bus: ZenohBus | None = None
    try:
        deployment = load_deployment(arguments.deployment)
        endpoints, log = deployment.endpoints(arguments.service), logging.getLogger(who)
        arguments.state_dir.mkdir(parents=True, exist_ok=True)
        bus = await open_with_logging(endpoints, log)
        pulse = Pulse()
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(say_alive(pulse))
            tasks.create_task(warn_daily([deployment], log))
            await _watch_links(tasks, bus, deployment, arguments.service, log)
            context = ServiceContext(
                name=arguments.service,
                deployment=deployment,
                options=deployment.services[arguments.service].options,
                state_dir=arguments.state_dir,
                bus=bus,
                stopping=signals.stopping,
                tasks=tasks,
                queries=QueryTasks(tasks, bus, arguments.service),
                started=signals.started,
                pulse=pulse,
            )
            await body(context)
            for task in asyncio.all_tasks() - {asyncio.current_task()}:
                task.cancel()
        return 0
    except Exception as error:  # noqa: BLE001 - each is said; a bug with its traceback
        for one in each_error(error):
            _say(who, one)
        return 1
    finally:
        signals.end_in_time()
        if bus is not None:
            await asyncio.to_thread(bus.close)


def _say(who: str, error: Exception) -> None:
    if isinstance(error, FairleadError):
        flush_log()
        print(stamped(f"ERROR {who}: {error}", who), flush=True)
    else:
        text = f"internal error, {type(error).__name__}: {error}"
        logging.getLogger(who).error("%s", text, exc_info=error)


def announce_ready(context: ServiceContext) -> None:
    """Declare the liveliness token that tools wait for, and say so in the log; on any thread."""
    gc.collect()
    gc.freeze()  # what is loaded stays: to search it again for garbage takes longer than a tick
    context.started()
    context.bus.declare_token(context.deployment.keys.alive(context.name))
    logging.getLogger(context.name).info("ready")
    say_ready()


async def run_in_thread(
    context: ServiceContext, name: str, function: Callable[[threading.Event], T]
) -> T:
    """Run what blocks, from start to end on one thread of its own.

    Args:
        function: its event is set when the service is asked to end; it then returns.
    """
    ending = threading.Event()
    thread = ThreadPoolExecutor(1, thread_name_prefix=name)
    running = asyncio.get_running_loop().run_in_executor(thread, function, ending)
    telling = asyncio.create_task(_set_when(context.stopping, ending))
    try:
        return await asyncio.shield(running)
    finally:
        ending.set()
        telling.cancel()
        await asyncio.wait({running})
        thread.shutdown(wait=False)


async def _set_when(stopping: asyncio.Event, ending: threading.Event) -> None:
    await stopping.wait()
    ending.set()
