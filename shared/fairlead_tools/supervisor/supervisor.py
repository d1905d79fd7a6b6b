"""The processes of one deployment on this host, from the first check to the last SIGKILL."""

from __future__ import annotations

import asyncio
import shutil
import time
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, ServiceEntry, running_name
from fairlead.errors import ConfigError, ServiceError
from fairlead.operate.changes import Changes
from fairlead_tools.supervisor.child import Child, LineHandler
from fairlead_tools.supervisor.command_line import (
    CommandBuilder,
    service_command,
    service_environment,
)
from fairlead_tools.supervisor.listing import Listing
from fairlead_tools.supervisor.slot import Slot, digests
from fairlead_tools.supervisor.this_host import check_places_free

STOP_GRACE_S = 5.0  # from SIGTERM to SIGKILL
ROUTER_READY_S = 30.0
LIST_AGAIN_S = 1.0


Kind = Literal["died", "restarted", "ready", "failed"]


@dataclass(frozen=True)
class ServiceEvent:
    """Something a person should read: a service died, was (or could not be) started again, ..."""

    service: str
    kind: Kind
    text: str


EventHandler = Callable[[ServiceEvent], None]


class Supervisor:
    """Runs one deployment's processes here. Use it on one event loop, whose thread lives as long.

    Args:
        deployment_file: where ``deployment`` was read from; the services read it too.
        state_dir: gets ``<service>/`` for each service's state and ``logs/``.
        on_line: called from a service's own thread for every line it prints.
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
        host: str | None = None,
        leave_out: Collection[str] = (),
    ) -> None:
        self.deployment = deployment
        self.name = running_name(deployment, host)
        self.processes = [n for n in deployment.processes(host) if n not in leave_out]
        self.state_dir = state_dir.absolute()
        self._file = deployment_file.absolute()
        self._on_line = on_line
        self._build_command = command
        registry = registry if registry is not None else Registry()
        self._listing = Listing(registry, self.name, self._file, self.state_dir)
        self._slots: dict[str, Slot] = {}
        self._changes = Changes()
        self._is_listed = True

    async def start(
        self, order: Sequence[str] | None = None, one_by_one_s: float | None = None
    ) -> None:
        """Start every process, in the file's order (the router first) or in ``order``.

        Args:
            one_by_one_s: wait up to so long for each to be ready before the next starts;
                None starts them all at once.

        Raises:
            ServiceError: something of this deployment still runs, or a port is taken.
            ConfigError: the gate is not built, its file not compiled, or ``order`` does
                not name each service once.

        To be followed by `stop` also if it raises.
        """
        names = self._in_order(order)
        commands = {name: self._command(name) for name in names}
        self.reserve()
        check_places_free(self.deployment, names)
        for name in names:
            self._slots[name] = self._first_start(name, commands[name])
            self._write_entry()
            if one_by_one_s is not None:
                await self.wait_ready(one_by_one_s)
            elif name == ROUTER:  # or its clients would begin with complaints
                await self.wait_ready(ROUTER_READY_S)

    def reserve(self) -> None:
        """List this deployment as running here, before its first process is started.

        Raises:
            ServiceError: it runs already, or something of it does.
        """
        services = self.deployment.services.items()
        gate = next((name for name, spec in services if spec.run == "safety"), "")
        self._listing.reserve(self.processes, gate)

    async def wait_ready(self, timeout_s: float) -> None:
        """Wait until every service has said ``ready``; one that `keep` starts again, once more.

        Raises:
            ServiceError: one died before, or took too long; with its last lines.
        """
        if not await self._changes.wait_for(self._all_ready, timeout_s):
            slow = next(name for name, slot in self._slots.items() if not slot.child.ready)
            raise ServiceError(self._story(slow, f"not ready after {timeout_s:g} s"))
        self._write_entry()

    async def keep(self, on_event: EventHandler) -> None:
        """Start again whatever dies, and say so, until cancelled."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._list_again(on_event), name="list")
            for name, slot in self._slots.items():
                tasks.create_task(self._keep(name, slot, on_event), name=f"keep {name}")

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

    async def stop(self, grace_s: float = STOP_GRACE_S) -> list[str]:
        """End every process: SIGTERM, then SIGKILL after the grace, whole groups.

        To be called when `keep` has ended.

        Returns:
            The services that had to be killed.

        Raises:
            ServiceError: some live on; they stay listed, for ``ps`` and ``down``.
        """
        children = [slot.child for slot in self._slots.values()]
        for child in children:
            child.ask_to_stop()
        await self._changes.wait_for(lambda: all(child.ended for child in children), grace_s)
        killed = [child.name for child in children if child.exit_status is None]
        left = await asyncio.gather(*(child.kill_group() for child in children))
        living = {child.name: pids for child, pids in zip(children, left, strict=True) if pids}
        self._listing.leave(  # of each on its first process: the service itself, if it lives
            {
                name: ServiceEntry(process_id(pids[0]), False, self._slots[name].restarts)
                for name, pids in living.items()
            }
        )
        self._slots.clear()
        if living:
            names = ", ".join(f"{name} (pid {_numbers(pids)})" for name, pids in living.items())
            raise ServiceError(
                f"deployment {self.name}: processes live on after SIGKILL: {names}; look at them: "
                f"fairlead ps; when what holds them has let go: fairlead down {self.name}"
            )
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
        self.state_dir.mkdir(mode=0o700, parents=True, exist_ok=True)  # nobody else's to read
        (self.state_dir / name).mkdir(exist_ok=True)
        log, changed = self.state_dir / "logs" / f"{name}.log", self._changes.announce
        if shutil.which(command[0]) is None:
            raise ServiceError(f"{name}: cannot start {command[0]}: no such program")
        try:
            return Child(name, command, service_environment(), log, self._on_line, changed)
        except OSError as error:
            raise ServiceError(f"{name}: cannot start {command[0]}: {error.strerror}") from None

    def _first_start(self, name: str, command: list[str]) -> Slot:
        files = digests(command)
        return Slot(self._spawn(name, command), time.monotonic(), files)

    def _all_ready(self) -> bool:
        for name, slot in self._slots.items():
            if slot.start_failed:
                raise ServiceError(self._story(name, _how_it_ended(slot.child.exit_status)))
        return all(slot.child.ready for slot in self._slots.values())

    async def _keep(self, name: str, slot: Slot, on_event: EventHandler) -> None:
        def tell(kind: Kind, text: str) -> None:
            self._list(on_event)
            on_event(ServiceEvent(name, kind, text))

        while True:
            await self._changes.wait_for(lambda: slot.child.ready or slot.child.ended, None)
            if slot.start_failed:
                return  # `wait_ready` says so
            if slot.child.ready and not slot.told:
                slot.told = True
                if slot.restarts:
                    tell("ready", f"{name} is ready again")
                else:
                    self._list(on_event)
            await self._changes.wait_for(lambda: slot.child.ended, None)
            ended = _how_it_ended(slot.child.exit_status)
            with suppress(OSError):  # said where it is started again
                await slot.child.kill_group()  # what the dead one had started
            delay_s = slot.backoff.delay_s(time.monotonic() - slot.started_s)
            tell("died", f"{name} {ended}; starting it again in {delay_s:g} s")
            while slot.child.ended:
                await asyncio.sleep(delay_s)
                try:
                    if left := await slot.child.kill_group():
                        raise ServiceError(f"pid {_numbers(left)} of it lives on after SIGKILL")
                    text = self._restart(name, slot)
                except Exception as error:  # noqa: BLE001 - whatever it is, the others go on
                    delay_s = slot.backoff.delay_s(0.0)
                    again = f"next attempt in {delay_s:g} s"
                    tell("failed", f"{name} cannot be started again: {error}; {again}")
                else:
                    tell("restarted", text)

    def _restart(self, name: str, slot: Slot) -> str:
        command = self._command(name)
        files = digests(command)
        child = self._spawn(name, command)
        changed = slot.replace(child, files, time.monotonic())
        text = f"{name} started again (pid {child.pid}, #{slot.restarts})"
        return f"{text}, CHANGED since its last start: {', '.join(changed)}" if changed else text

    def _list(self, on_event: EventHandler) -> None:
        was_listed = self._is_listed
        try:
            self._write_entry()
            self._is_listed = True
        except OSError as error:  # `ps` shows what was true before; the services go on
            self._is_listed = False
            if was_listed:
                text = f"cannot say what runs here: {error.filename}: {error.strerror}"
                on_event(ServiceEvent("up", "failed", text))

    async def _list_again(self, on_event: EventHandler) -> None:
        """What a full disk left out, once there is room."""
        while True:
            await asyncio.sleep(LIST_AGAIN_S)
            if not self._is_listed:
                self._list(on_event)

    def _story(self, name: str, what: str) -> str:
        lines = "".join(f"\n  [{name}] {line}" for line in self.last_lines(name))
        log = self.state_dir / "logs" / f"{name}.log"
        return f"{name}: {what}; its last lines ({log}):{lines or ' none'}"

    def _write_entry(self) -> None:
        self._listing.write({name: slot.entry for name, slot in self._slots.items()})


def _numbers(pids: Sequence[int]) -> str:
    return " ".join(str(pid) for pid in pids)


def _how_it_ended(status: int | None) -> str:
    assert status is not None
    return f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
