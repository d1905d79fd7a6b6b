"""What every Python service's ``main`` does: arguments, session, alive token, clean end."""

from __future__ import annotations

import argparse
import logging
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.router_watch import open_and_say, refuse_namesake, watch_router
from fairlead.deploy.stop_signals import StopSignals
from fairlead.errors import FairleadError
from fairlead.log_stamp import stamped
from fairlead.wire.printable import LineFormatter
from fairlead.wire.session import ZenohBus

__all__ = ["ServiceContext", "announce_ready", "run_service"]


@dataclass(frozen=True)
class ServiceContext:
    """What a service knows about itself when it starts.

    Attributes:
        name: the service's name in the deployment file; also its source in keys.
        options: its ``options`` block, still to be checked by the service.
        state_dir: an existing folder for this service's logs and state.
        stopping: set when the process was asked to end; safe to wait for without a timeout.
        started: `announce_ready` calls it; asked to end before, the process just ends.
    """

    name: str
    deployment: Deployment
    options: dict[str, Any]
    state_dir: Path
    bus: ZenohBus
    stopping: threading.Event
    started: Callable[[], None]


def run_service(who: str, body: Callable[[ServiceContext], None]) -> int:
    """Run ``body`` until it returns or the process is asked to stop (SIGTERM, SIGINT).

    Asked to stop, or once the body has returned, the process ends within a few seconds
    even if something in it hangs (exit status 1 then).

    Prints ``ready`` from the body's point of view with `announce_ready`.

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
    handler = logging.StreamHandler(sys.stdout)
    handler.setFormatter(LineFormatter())
    logging.basicConfig(level=logging.INFO, handlers=[handler])
    signals = StopSignals(who)
    bus: ZenohBus | None = None
    try:
        deployment = load_deployment(arguments.deployment)
        endpoints, log = deployment.endpoints(arguments.service), logging.getLogger(who)
        arguments.state_dir.mkdir(parents=True, exist_ok=True)
        bus = open_and_say(endpoints, log)
        if deployment.router is not None:
            refuse_namesake(arguments.service, bus, deployment.keys.alive(arguments.service))
            watch_router(bus, deployment.router_endpoint, log, signals.stopping)
        body(
            ServiceContext(
                name=arguments.service,
                deployment=deployment,
                options=deployment.services[arguments.service].options,
                state_dir=arguments.state_dir,
                bus=bus,
                stopping=signals.stopping,
                started=signals.started,
            )
        )
        return 0
    except FairleadError as error:
        print(stamped(f"ERROR {who}: {error}", who), flush=True)
        return 1
    finally:
        signals.end_in_time()
        signals.stopping.set()  # for whoever still watches
        if bus is not None:
            bus.close()


def announce_ready(context: ServiceContext) -> None:
    """Declare the liveliness token that tools wait for, and say so in the log."""
    context.started()
    context.bus.declare_token(context.deployment.keys.alive(context.name))
    logging.getLogger(context.name).info("ready")
