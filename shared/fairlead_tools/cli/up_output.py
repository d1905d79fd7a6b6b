"""What ``fairlead up`` waits for, also on other hosts, what it says, and where that is printed."""

from __future__ import annotations

import asyncio
import os
import queue
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.router_watch import open_patiently
from fairlead.deploy.service_spec import EXTERNAL
from fairlead.errors import FairleadError, TransportError
from fairlead.log_stamp import stamped
from fairlead.messages import GateState, GateStatus
from fairlead.operate.asker import own_endpoints
from fairlead.operate.robot import Robot
from fairlead.wire.printable import printable_lines
from fairlead_tools.cli.console import forget_output, hex_id
from fairlead_tools.cli.status import state_and_cause
from fairlead_tools.supervisor.service_log import ServiceLog

Say = Callable[[str, str], None]
PATIENCE_S = 10.0


class Greeting:
    """Says, once, that the robot is up and what to do next; names what it waits for.

    Attributes:
        fault: of the HAL, which came before any state, and was said; it stays until a restart.
    """

    def __init__(self, robot: Robot, folder: Path, say: Say) -> None:
        self._robot = robot
        self._folder = folder
        self._say = say
        self._complain_at_s = time.monotonic() + PATIENCE_S
        self._done = False
        self.fault = ""

    async def say_once_up(self) -> bool:
        """Call it a few times a second: it waits for nobody while somebody is missing.

        Returns:
            Whether it was said just now.
        """
        if self._done:
            return False
        gate, trouble = await self._following_gate()
        if gate is not None:
            self._done = True
            self._greet(gate)
        elif time.monotonic() > self._complain_at_s:
            self._complain_at_s += PATIENCE_S
            self._say("up", f"not up yet: {trouble}")
        return gate is not None

    async def _following_gate(self) -> tuple[GateStatus | None, str]:
        """The gate's status once it follows the HAL; else what is missing."""
        missing = set(self._robot.deployment.services) - self._robot.alive
        if missing:
            return None, f"{', '.join(sorted(missing))} not seen"
        try:
            gate = await self._robot.following_gate()
            hal = await self._robot.hal_status() if gate is None else None
        except FairleadError as error:
            return None, str(error)
        if hal is not None and hal.state == "fault" and hal.detail != self.fault:
            self.fault = hal.detail
            name = self._robot.deployment.hal
            self._say("up", f"fault of {name}: {hal.detail}; then: fairlead restart {name}")
        return gate, "the gate has no state of this HAL yet; see: fairlead status"

    def _greet(self, gate: GateStatus) -> None:
        self._say("up", f"{self._robot.deployment.id} is up; state and logs: {self._folder}")
        if gate.state == GateState.DISARMED:
            if self._robot.deployment.runners:
                next_step = "fairlead run SKILL   (see: fairlead skill ls)"
            else:  # no service of the file runs skills
                next_step = "fairlead status; fairlead arm for a program of your own"
            self._say("up", f"in another terminal: {next_step}")
        else:
            explain_gate(gate, self._say)


def explain_gate(gate: GateStatus, say: Say) -> None:
    """Say why the gate will not arm, and the commands that lead back to a goal."""
    say("up", f"the gate is {state_and_cause(gate)}")
    for one in (gate.latch_id, *gate.stop_ids):
        if one:
            say("up", f"when the cause is gone: fairlead reset {hex_id(one)}")


SETTLE_S = 1.0
"""Services that start together are not announced as missing one by one."""


async def wait_router(deployment: Deployment, say: Say) -> None:
    """Wait until the router on another host is there; at once where there is none."""
    if deployment.router is None:
        return
    said: list[str] = []

    def on_wait(error: TransportError) -> None:
        if not said:
            said.append(str(error))
            say("up", f"waiting: {error}")

    bus = await open_patiently(own_endpoints(deployment), on_wait)
    await asyncio.to_thread(bus.close)
    if said:
        say("up", f"router {deployment.router_endpoint} reached")


class OtherHosts:
    """Says which services of other hosts are missing, whenever that changes.

    Args:
        here: names of the processes of this host; those are somebody else's to watch.
    """

    def __init__(self, robot: Robot, here: Collection[str], say: Say) -> None:
        self._robot = robot
        self._deployment = robot.deployment
        self._others = set(self._deployment.services) - set(here)
        self._say = say
        self._said: set[str] = set()
        self._missing: set[str] = set()
        self._since_s = time.monotonic()

    @property
    def said_missing(self) -> bool:
        """Whether one is missing, and that was said."""
        return bool(self._said)

    def are_there(self) -> bool:
        """Whether every one is alive now; call it a few times a second."""
        missing = self._others - self._robot.alive
        now_s = time.monotonic()
        if missing != self._missing:
            self._missing, self._since_s = missing, now_s
        if missing != self._said and (not missing or now_s - self._since_s > SETTLE_S):
            self._said = missing
            self._report(missing)
        return not missing

    def _report(self, missing: Collection[str]) -> None:
        if missing:
            names = ", ".join(self._deployment.with_host(name) for name in sorted(missing))
            hosts = sorted({self._deployment.services[name].host for name in missing} - {""})
            there = ", ".join(f"fairlead up FILE --host {host}" for host in hosts)
            by_hand = ", ".join(self._command(name) for name in sorted(missing))
            how = f"start there: {there}" if hosts else f"start with: {by_hand}"
            self._say("up", f"not seen yet: {names}; {how}")
        else:
            self._say("up", "every service that others started is there")

    def _command(self, service: str) -> str:
        if self._deployment.services[service].run == EXTERNAL:
            return f"whatever {service} is (run: {EXTERNAL})"
        return f"fairlead service FILE {service}"


MOST_LINES = 1000
"""That wait for a terminal which takes none; more are only in the logs."""
LAST_WORDS_S = 2.0


class UpOutput:
    """Where ``up`` prints: the terminal, until it is detached; its own lines in a log too.

    A thread of its own prints, as a terminal may take nothing for hours.

    Attributes:
        has_lost_reader: whatever read the output has gone; SIGTERM was raised then, once.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / "logs" / "up.log"
        self._log = ServiceLog(self._path)
        self._lines: queue.Queue[str | None] = queue.Queue(MOST_LINES)
        self.has_lost_reader = False
        self._thread = threading.Thread(target=self._print, name="terminal", daemon=True)
        self._thread.start()

    def __call__(self, service: str, line: str) -> None:
        """Print a line of one service, or of ``up``."""
        if service == "up":
            self._log.append(stamped(f"INFO up: {line}", service))
        self._put(f"[{service}] {line}")

    def close(self) -> None:
        """Have nothing left that would fail to be written when the process ends."""
        with suppress(OSError):  # a full disk behind a redirection
            if self._ends():
                sys.stdout.flush()
                return
        forget_output()

    def detach(self) -> None:
        """Close the output; what would still be printed there is appended to the log."""
        if self._ends():
            sys.stdout.flush()
        self._path.parent.mkdir(parents=True, exist_ok=True)
        log = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(log, stream.fileno())
        os.close(log)

    def _put(self, line: str) -> None:
        with suppress(queue.Full):
            if self._thread.is_alive():
                self._lines.put_nowait(line)

    def _ends(self) -> bool:
        """Have the last lines printed; whether the terminal took them."""
        until_s = time.monotonic() + LAST_WORDS_S
        with suppress(queue.Full):
            self._lines.put(None, timeout=LAST_WORDS_S)
        self._thread.join(max(0.0, until_s - time.monotonic()))
        return not self._thread.is_alive()

    def _print(self) -> None:
        while (line := self._lines.get()) is not None:
            try:
                _write(line)
            except BrokenPipeError:  # end as on Ctrl-C, and say why where somebody may read it
                again, self.has_lost_reader = self.has_lost_reader, True
                other = os.open(os.devnull, os.O_WRONLY) if again else sys.stderr.fileno()
                os.dup2(other, sys.stdout.fileno())
                if not again:
                    os.kill(os.getpid(), signal.SIGTERM)
            except OSError:  # a full disk behind a redirection: the logs have the line, or say so
                continue


def _write(line: str) -> None:
    """Past Python's own output, whose lock would be held for as long as the terminal is stuck."""
    data = f"{printable_lines(line)}\n".encode(errors="backslashreplace")
    while data:
        try:
            data = data[os.write(sys.stdout.fileno(), data) :]
        except BlockingIOError:  # others may have set the terminal so
            select.select([], [sys.stdout.fileno()], [])
