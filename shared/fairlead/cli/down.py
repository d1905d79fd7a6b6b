"""``fairlead down``: end a deployment's processes, also those an earlier run left behind."""

from __future__ import annotations

import os
import signal
import time

import typer

from fairlead.cli.deployment_choice import NameArgument, choose_running
from fairlead.errors import ServiceError
from fairlead.supervisor import Registry, Running
from fairlead.supervisor.process_table import ProcessId

EXAMPLE = "fairlead down panda_mobile"
SUPERVISOR_GRACE_S = 15.0  # its own grace for the services, and a margin
SERVICE_GRACE_S = 3.0
POLL_S = 0.05


def command(name: NameArgument = None) -> None:
    """Stop a deployment that runs on this machine, and wait until its processes are gone."""
    entry = choose_running(name)
    if entry.is_supervised:
        end_processes([entry.supervisor], SUPERVISOR_GRACE_S)
    left = entry.leftovers
    if left:
        end_processes(left, SERVICE_GRACE_S)
    _check_gone(entry)
    Registry().remove(entry.name)
    typer.echo(f"stopped {entry.name}" + (f" and {len(left)} leftover processes" if left else ""))


def end_processes(processes: list[ProcessId], grace_s: float) -> None:
    """SIGTERM, then SIGKILL to those still there after the grace."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        for process in processes:
            if process.is_running:
                os.kill(process.pid, number)
        deadline = time.monotonic() + grace_s
        while any(p.is_running for p in processes) and time.monotonic() < deadline:
            time.sleep(POLL_S)


def _check_gone(entry: Running) -> None:
    if entry.is_supervised or entry.leftovers:
        pids = [entry.supervisor] if entry.is_supervised else entry.leftovers
        numbers = " ".join(str(process.pid) for process in pids)
        raise ServiceError(f"{entry.name}: could not end pid {numbers}; try: kill -9 {numbers}")
