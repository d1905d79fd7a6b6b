"""The processes of one deployment on this host, from the first check to the last SIGKILL."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Literal

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.process_table import ProcessId, process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry, running_name
from fairlead.errors import ConfigError, ServiceError
from fairlead_tools.supervisor.child import Child, LineHandler
from fairlead_tools.supervisor.command_line import (
    CommandBuilder,
    service_command,
    service_environment,
)
from fairlead_tools.supervisor.slot import Slot, digests
from fairlead_tools.supervisor.this_host import check_ports_free

STOP_GRACE_S = 5.0  # from SIGTERM to SIGKILL
POLL_S = 0.05
ROUTER_READY_S = 30.0


@dataclass(frozen=True)
class ServiceEvent:
    """Something a person should read: a service died, was (or could not be) started again, ..."""

    service: str
    kind: Literal["died", "restarted", "ready", "failed"]
    text: str


class Supervisor:
    """Runs one deployment's processes here. Use it from one thread that lives as long.

    Args:
        deployment_file: where ``deployment`` was read from; the services read it too.
        state_dir: gets ``<service>/`` for each service's state and ``logs/``.
        on_line: called from a thread for every line a service prints.
        registry: where the deployment is listed while it runs.
        command: builds a service's command line.
        host: which of the deployment's hosts this is; None where it has none.
        leave_out: names of processes that somebody else runs.
    """

    def __init__(
        self,
        deployment_file: Path,
        deployment: Deployment,
        state_dir: Path,
        on_line: LineHandler = lambda service, line: None,
        registry: Registry | None = None,
        command: CommandBuilder = service_command,
        clock: Callable[[], float] = time.monotonic,
        host: str | None = None,
        leave_out: Collection[str] = (),
    ) -> None:
        self.deployment = deployment
        self.name = running_name(deployment, host)
        self.processes = [n for n in deployment.processes(host) if n not in leave_out]
        self.state_dir = state_dir.absolute()
        self._file = deployment_file.absolute()
        self._on_line = on_line
        self._registry = registry if registry is not None else Registry()
        self._build_command = command
        self._clock = clock
        self._is_listed = False
        self._slots: dict[str, Slot] = {}
        self._lock: IO[str] | None = None

    def start(self, order: Sequence[str] | None = None, one_by_one_s: float | None = None) -> None:
        """Start every process, in the file's order (the router first) or in ``order``.

        Args:
            one_by_one_s: wait up to so long for each to be ready before the next starts;
                None starts them all at once.

        Raises:
            ServiceError: something of this deployment still runs, or a port is taken.
            ConfigError: the gate is not built, its file not compiled, or ``order`` does
                not name each service once.
        """
        names = self._in_order(order)
        commands = {name: self._command(name) for name in names}
        self.reserve()
        try:
            check_ports_free(self.deployment, names)
            for name in names:
                self._slots[name] = self._first_start(name, commands[name])
                self._write_entry()
                if one_by_one_s is not None:
                    self.wait_ready(one_by_one_s)
                elif name == ROUTER:  # or its clients would begin with complaints
                    self.wait_ready(ROUTER_READY_S)
        except BaseException:
            self.stop(grace_s=0.0)
            raise

    def reserve(self) -> None:
        """List this deployment as running here, before its first process is started.

        Raises:
            ServiceError: it runs already, or something of it does.
        """
        if self._lock is not None:
            return
        self._lock = self._registry.lock(self.name)
        try:
            self._refuse_leftovers()
            self._write_entry()
        except BaseException:
            self.stop(grace_s=0.0)
            raise

    def wait_ready(
        self,
        timeout_s: float,
        stopping: threading.Event | None = None,
        on_event: Callable[[ServiceEvent], None] = lambda event: None,
    ) -> None:
        """Wait until every service has said ``ready``, or ``stopping`` is set.

        One that dies after it was ready is started again, as later.

        Raises:
            ServiceError: one died before, or took too long; with its last lines.
        """
        deadline = self._clock() + timeout_s
        while stopping is None or not stopping.is_set():
            slow = next((n for n, slot in self._slots.items() if not slot.child.ready.is_set()), "")
            if not slow:
                break
            self._raise_if_start_failed()
            if self._clock() > deadline:
                raise ServiceError(self._story(slow, f"not ready after {timeout_s:g} s"))
            for event in self.poll():
                on_event(event)
            self._slots[slow].child.ready.wait(POLL_S)
        self._write_entry()

    def poll(self) -> list[ServiceEvent]:
        """Notice deaths, start again what is due; call it a few times a second."""
        events, changed = [], False
        for name, slot in self._slots.items():
            if slot.restart_at_s is not None:
                if self._clock() >= slot.restart_at_s:
                    events.append(self._restart(name, slot))
            elif slot.child.exit_status is not None:
                events.append(self._bury(name, slot))
            elif not slot.was_ready and slot.child.ready.is_set():
                slot.was_ready = changed = True
                if slot.restarts:
                    events.append(ServiceEvent(name, "ready", f"{name} is ready again"))
        if events or changed:
            try:
                self._write_entry()
            except OSError as error:  # `ps` shows what was true before; the services go on
                text = f"cannot say what runs here: {error.filename}: {error.strerror}"
                events.append(ServiceEvent("up", "failed", text))
        return events

    def pid(self, service: str) -> int:
        """Process number of one service now."""
        return self._slots[service].child.pid

    def last_lines(self, service: str) -> list[str]:
        """What one service printed last."""
        return list(self._slots[service].child.last_lines)

    def died(self) -> str | None:
        """The story of the first service that is dead now, None if all live."""
        for name, slot in self._slots.items():
            if slot.child.exit_status is not None:
                return self._story(name, _how_it_ended(slot.child.exit_status))
        return None

    def stop(self, grace_s: float = STOP_GRACE_S) -> list[str]:
        """End every process: SIGTERM, then SIGKILL after the grace, whole groups.

        Returns:
            The services that had to be killed.
        """
        deadline = self._clock() + grace_s
        for slot in self._slots.values():
            slot.child.ask_to_stop()
        killed = []
        for name, slot in self._slots.items():
            if not slot.child.wait(deadline - self._clock()):
                killed.append(name)
            slot.child.kill_group()
        self._slots.clear()
        if self._is_listed:
            self._registry.remove(self.name)
            self._is_listed = False
        if self._lock is not None:
            self._lock.close()
            self._lock = None
        return killed

    def _in_order(self, order: Sequence[str] | None) -> list[str]:
        if order is not None and sorted(order) != sorted(self.processes):
            raise ConfigError(
                f"start order: expected each of {', '.join(self.processes)} once, "
                f"got {', '.join(order)}"
            )
        return self.processes if order is None else list(order)

    def _command(self, name: str) -> list[str]:
        return self._build_command(self._file, self.deployment, name, self.state_dir / name)

    def _spawn(self, name: str, command: list[str]) -> Child:
        (self.state_dir / name).mkdir(parents=True, exist_ok=True)
        log = self.state_dir / "logs" / f"{name}.log"
        try:
            return Child(name, command, service_environment(), log, self._on_line)
        except OSError as error:
            raise ServiceError(f"{name}: cannot start {command[0]}: {error.strerror}") from None

    def _first_start(self, name: str, command: list[str]) -> Slot:
        files = digests(command)
        return Slot(self._spawn(name, command), self._clock(), files)

    def _restart(self, name: str, slot: Slot) -> ServiceEvent:
        try:
            command = self._command(name)
            files = digests(command)
            child = self._spawn(name, command)
        except Exception as error:  # noqa: BLE001 - whatever it is, the other services go on
            delay_s = slot.try_later(self._clock(), 0.0)
            text = f"{name} cannot be started again: {error}; next attempt in {delay_s:g} s"
            return ServiceEvent(name, "failed", text)
        changed = slot.replace(child, files, self._clock())
        text = f"{name} started again (pid {child.pid}, #{slot.restarts})"
        if changed:
            text += f", CHANGED since its last start: {', '.join(changed)}"
        return ServiceEvent(name, "restarted", text)

    def _bury(self, name: str, slot: Slot) -> ServiceEvent:
        status = slot.child.exit_status
        assert status is not None
        slot.child.kill_group()  # what the dead one had started
        delay_s = slot.try_later(self._clock(), self._clock() - slot.started_s)
        return ServiceEvent(
            name, "died", f"{name} {_how_it_ended(status)}; starting it again in {delay_s:g} s"
        )

    def _raise_if_start_failed(self) -> None:
        for name, slot in self._slots.items():
            status = slot.child.exit_status
            if status is not None and slot.restarts == 0 and not slot.child.ready.is_set():
                raise ServiceError(self._story(name, _how_it_ended(status)))

    def _story(self, name: str, what: str) -> str:
        lines = "".join(f"\n  [{name}] {line}" for line in self.last_lines(name))
        log = self.state_dir / "logs" / f"{name}.log"
        return f"{name}: {what}; its last lines ({log}):{lines or ' none'}"

    def _refuse_leftovers(self) -> None:
        entry = self._registry.find(self.name)
        services = entry.services if entry is not None else {}
        still = [
            f"{name} (pid {service.running.pid})"
            for name, service in services.items()
            if name in self.processes and service.running
        ]
        if still:
            raise ServiceError(
                f"deployment {self.name}: processes that were started before still run: "
                f"{', '.join(still)}; end them first: fairlead down {self.name}"
            )

    def _write_entry(self) -> None:
        if self._slots:
            services = {name: slot.entry for name, slot in self._slots.items()}
        else:
            services = dict.fromkeys(self.processes, ServiceEntry(None, False, 0))
        self._is_listed = True
        own = process_id(os.getpid()) or ProcessId(os.getpid(), 0)
        self._registry.write(
            Running(self.name, str(self._file), str(self.state_dir), own, services)
        )


def _how_it_ended(status: int) -> str:
    return f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
