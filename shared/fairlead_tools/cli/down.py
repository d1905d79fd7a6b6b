"""``fairlead down``: end a deployment's processes, also those an earlier run left behind."""

from __future__ import annotations

import signal
import time
from pathlib import Path

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.process_table import ProcessId
from fairlead.deploy.registry import Registry, Running
from fairlead.errors import FairleadError, ServiceError
from fairlead.operate.client import RobotClient
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.deployment_choice import RunningArgument, choose_running

EXAMPLE = "fairlead down panda_mobile"
SUPERVISOR_GRACE_S = 15.0  # its own grace for the services, and a margin
SERVICE_GRACE_S = 3.0
POLL_S = 0.05


def command(deployment: RunningArgument = None) -> None:
    """Stop a deployment that runs on this machine, and wait until its processes are gone.

    Ends what `fairlead up` and `fairlead service` started.
    """
    entry = choose_running(deployment)
    if entry.supervisor is not None:
        end_processes([entry.supervisor], SUPERVISOR_GRACE_S)
        _check_gone(entry.name, [entry.supervisor])
    if entry.by_hand:
        _disarm(entry)
    left = _leftovers(entry)
    if left:
        end_processes(left, SERVICE_GRACE_S)
    _check_gone(entry.name, left)
    Registry().remove_if_ended(entry.name)
    echo(f"stopped {entry.name}" + (f" and {len(left)} leftover processes" if left else ""))


def end_processes(processes: list[ProcessId], grace_s: float) -> None:
    """SIGTERM, then SIGKILL to those still there after the grace."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        for process in processes:
            process.send(number)
        deadline = time.monotonic() + grace_s
        while any(p.is_running for p in processes) and time.monotonic() < deadline:
            time.sleep(POLL_S)


def _leftovers(entry: Running) -> list[ProcessId]:
    """What still runs, by the newest word: a supervisor starts processes until it ends."""
    newest = Registry().find(entry.name)
    if newest is None or newest.is_supervised:  # the latter: started again by somebody else
        return []
    return newest.leftovers


def _disarm(entry: Running) -> None:
    """End claims before the processes, so that a gate started by hand ends cleanly too."""
    try:
        with RobotClient(load_deployment(Path(entry.deployment)), by="fairlead down") as client:
            client.disarm()
    except FairleadError:  # no gate, or one that is not armed: nothing to end
        return


def _check_gone(name: str, processes: list[ProcessId]) -> None:
    still = [str(process.pid) for process in processes if process.is_running]
    if still:
        numbers = " ".join(still)
        raise ServiceError(f"{name}: could not end pid {numbers}; try: kill -9 {numbers}")
