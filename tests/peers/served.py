"""Servers of the peers' environment, and policies of ours that ask them."""

from __future__ import annotations

import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from bench.equipment.live_robot import wait_for
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner.fitted_rows import fitted
from fairlead_tools.supervisor.this_host import free_ports
from tests.peers.environment import peer


@contextmanager
def serving(module: str, *arguments: str, port: int | None = None) -> Iterator[int]:
    """A server of the peers' environment on a port of ours, from when it can be reached."""
    port = free_ports(1)[0] if port is None else port
    command = [*peer(module), arguments[0], str(port), *arguments[1:]]

    def is_up() -> bool:
        assert server.poll() is None, "the server ended; above is what it said"
        with suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
            return True
        return False

    with subprocess.Popen(command) as server:
        try:
            wait_for(is_up, f"{module} listens", 60.0)
            yield port
        finally:
            server.kill()


def made(skill: SkillManifest, kind: Any, address: str, **options: Any) -> Any:
    """The skill's policy with a server of ours."""
    return kind.from_options(skill, skill.policy.options | {"address": address} | options)


def admitted_rows(skill: SkillManifest, rows: Any) -> Any:
    """What goes to the gate of a policy's rows."""
    routes = resolve_routes(skill.action_contract, load_robot("panda_mobile"))
    return fitted(routes, rows)
