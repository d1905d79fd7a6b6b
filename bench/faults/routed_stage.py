"""The light robot with its services as clients of a router: behind proxies, or certified."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import yaml

from bench.equipment.bad_certificates import make_certificates
from bench.equipment.light_hal import LIGHT_HAL
from bench.equipment.live_robot import wait_for
from bench.faults.live_stage import SOURCE, Changes, LiveStage, with_skill
from bench.faults.proxy import FaultProxy, forward
from fairlead.deploy.credentials import forget_secrets
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.registry import Registry
from fairlead_tools.supervisor.scratch import Scratch, scratch_robot
from fairlead_tools.supervisor.this_host import free_ports

PROXIED = ("hal", "safety", "runner")
OPERATOR = "operator"
HOST = "robot"


class RoutedStage(LiveStage):
    """proxies: between each of `PROXIED`, or an operator, and the router."""

    proxies: dict[str, FaultProxy]
    operators_file: Path

    def router_restarted(self) -> None:
        """Let the supervisor bring the dead router back, and wait for everybody."""
        self.restarted(ROUTER)
        self.good_network()

    def good_network(self) -> None:
        """No faults any more, and everybody is back."""
        for proxy in self.proxies.values():
            proxy.both(forward)
        wait_for(
            lambda: set(self.client.deployment.services) <= self.client.alive, "everybody is back"
        )
        self.client.wait_gate_follows(60.0)


def routed_deployment(folder: Path, router_port: int) -> dict[str, Any]:
    """The shipped deployment on one host, around a router."""
    content: dict[str, Any] = yaml.safe_load(SOURCE.read_text(encoding="utf-8"))
    for spec in content["services"].values():
        spec["host"] = HOST
    content["services"]["hal"] = {**LIGHT_HAL, "host": HOST}
    content |= {"hosts": {HOST: "127.0.0.1"}, "pacing": "realtime", "id": f"routed{router_port}"}
    content["router"] = {"host": HOST, "port": router_port}
    content["access"] = "open"  # the proxies tell one message from the next
    return content


def _write(file: Path, content: dict[str, Any]) -> Deployment:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return load_deployment(file)


@contextmanager
def routed_stage(folder: Path, changes: Changes | None = None) -> Iterator[RoutedStage]:
    """Router, proxies and services, all started."""
    [router_port] = free_ports(1)
    content = routed_deployment(folder, router_port)
    file = folder / "state" / "deployment.yaml"
    scratch = Scratch(file, _write(file, content), file.parent)
    with ExitStack() as stack:
        proxies = {
            name: stack.enter_context(FaultProxy(router_port)) for name in (*PROXIED, OPERATOR)
        }
        files = {name: folder / f"{name}.yaml" for name in proxies}
        views = {
            name: _write(files[name], content | {"router": {"host": HOST, "port": proxy.port}})
            for name, proxy in proxies.items()
        }
        changes = with_skill(folder, changes or Changes())

        def words(own: Path, deployment: Deployment, service: str, state: Path) -> list[str]:
            if service not in PROXIED:
                return changes.words(own, deployment, service, state)
            return changes.words(files[service], views[service], service, state)

        registry = Registry(folder / "registry")
        robot = stack.enter_context(scratch_robot(scratch, registry, command=words))
        stage = RoutedStage(robot)
        stage.proxies, stage.operators_file = proxies, files[OPERATOR]
        yield stage


class CertifiedStage(LiveStage):
    """proofs: by kind of certificate, what a stranger proves itself with."""

    proofs: dict[str, dict[str, Any]]


@contextmanager
def certified_stage(folder: Path, **more: Any) -> Iterator[CertifiedStage]:
    """Router and services with certificates, without proxies; ``more`` is for the file."""
    content = routed_deployment(folder, free_ports(1)[0]) | {"access": "closed"} | more
    file = folder / "state" / "deployment.yaml"
    scratch = Scratch(file, _write(file, content), file.parent)
    proofs = make_certificates(scratch.deployment, HOST)
    changes, registry = with_skill(folder, Changes()), Registry(folder / "registry")
    try:
        with scratch_robot(scratch, registry, command=changes.words) as robot:
            stage = CertifiedStage(robot)
            stage.proofs = proofs
            yield stage
    finally:
        forget_secrets(scratch.deployment.keys)
