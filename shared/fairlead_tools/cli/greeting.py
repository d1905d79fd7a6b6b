"""What ``fairlead up`` waits for, also on other hosts, and says once the robot is there."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Collection
from pathlib import Path

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.router_watch import open_patiently
from fairlead.deploy.service_spec import EXTERNAL
from fairlead.errors import FairleadError, TransportError
from fairlead.messages import GateState, GateStatus
from fairlead.operate.asker import own_endpoints
from fairlead.operate.robot import Robot
from fairlead_tools.cli.console import hex_id
from fairlead_tools.cli.status import state_and_cause

Say = Callable[[str, str], None]
PATIENCE_S = 10.0


class Greeting:
    """Says, once, that the robot is up and what to do next; names what it waits for."""

    def __init__(self, robot: Robot, folder: Path, say: Say) -> None:
        self._robot = robot
        self._folder = folder
        self._say = say
        self._complain_at_s = time.monotonic() + PATIENCE_S
        self._done = False

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
        except FairleadError as error:
            return None, str(error)
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
