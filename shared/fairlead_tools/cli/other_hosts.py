"""What ``fairlead up`` waits for on the other hosts of a deployment, and says about them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection

from fairlead.deploy.deployment import EXTERNAL, Deployment
from fairlead.deploy.router_watch import open_patiently
from fairlead.errors import TransportError
from fairlead.operate.client import RobotClient

SETTLE_S = 1.0
"""Services that start together are not announced as missing one by one."""


class _AskedToEndError(Exception):
    """Leaves a wait that has no other end."""


def router_reached(
    deployment: Deployment, stopping: threading.Event, say: Callable[[str, str], None]
) -> bool:
    """Wait until the router on another host is there; at once where there is none.

    Returns:
        False if asked to stop meanwhile.
    """
    if deployment.router is None:
        return True
    said: list[str] = []

    def on_wait(error: TransportError) -> None:
        if stopping.is_set():
            raise _AskedToEndError
        if not said:
            said.append(str(error))
            say("up", f"waiting: {error}")

    try:
        open_patiently(deployment.tool_endpoints(), on_wait).close()
    except _AskedToEndError:
        return False
    if said:
        say("up", f"router {deployment.router_endpoint} reached")
    return not stopping.is_set()


class OtherHosts:
    """Says which services of other hosts are missing, whenever that changes.

    Args:
        here: names of the processes of this host; those are somebody else's to watch.
    """

    def __init__(
        self, client: RobotClient, here: Collection[str], say: Callable[[str, str], None]
    ) -> None:
        self._client = client
        self._deployment = client.deployment
        self._others = set(self._deployment.services) - set(here)
        self._say = say
        self._said: set[str] = set()
        self._missing: set[str] = set()
        self._since_s = time.monotonic()

    def are_there(self) -> bool:
        """Whether every one is alive now; call it a few times a second."""
        missing = self._others - self._client.alive
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
