"""Deployment files (``compose/*.yaml``): which services run where, and how they meet."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationInfo,
    field_validator,
    model_validator,
)

from fairlead.deploy.access import DIAL_ORDER, OPERATOR, Parties, Role, session_access
from fairlead.deploy.certificates import COMMON_NAME_MAX, common_name
from fairlead.deploy.credentials import find_secrets
from fairlead.deploy.hosts import (
    ROUTER,
    RouterSpec,
    endpoint_of,
    host_problems,
    long_names,
    people_problems,
    place_of,
    service_problems,
)
from fairlead.deploy.routed_access import client_access
from fairlead.deploy.service_spec import EXTERNAL, OWN_SERVICES, ServiceName, ServiceSpec
from fairlead.deploy.sockets import socket_endpoint
from fairlead.errors import ConfigError, expected
from fairlead.keys import Keys, check_name
from fairlead.plugins import HALS
from fairlead.wire.endpoints import Endpoints
from fairlead.yaml_file import load_yaml, locator

_FOLDERS = ("access", "router", "running")  # of what all robots of a machine have in common


class Deployment(BaseModel):
    """One robot's services.

    On one host they are peers: every service listens on its own socket and connects to those
    before it in `Parties.services`, so that each pair has exactly one link whatever the start
    order. On several hosts they, and all tools, are clients of one router.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    robot: str = Field(description="folder under robots/")
    id: str = Field(description="the robot's id in keys")
    namespace: str = "fl"
    profile: Literal["sim", "hardware"] = "sim"
    pacing: Literal["realtime", "lockstep"] = "lockstep"
    localiser: str = Field(
        default="", description="who sends map -> odom, as <name> in tf/<name>; empty: the HAL"
    )
    access: Literal["closed", "open"] = Field(
        default="closed", description="open: whoever reaches a service may do anything"
    )
    hosts: dict[str, str] = Field(default_factory=dict, description="address of each host")
    router: RouterSpec | None = None
    people: tuple[str, ...] = Field(
        default=(), description="who alone may command the robot, each with a certificate"
    )
    services: dict[ServiceName, ServiceSpec]

    _file: Path | None = PrivateAttr(default=None)  # where it was read

    @field_validator("id", "namespace", "localiser")
    @classmethod
    def _key_chunk(cls, value: str, field: ValidationInfo) -> str:
        if field.field_name == "localiser" and not value:
            return value
        if field.field_name == "id" and value in _FOLDERS:
            raise ValueError(f"expected another id: {value} is a folder of all robots")
        try:
            return check_name("deployment", value)
        except ConfigError as error:
            raise ValueError(str(error)) from None  # so that the file's other problems show too

    @model_validator(mode="after")
    def _places_fit(self) -> Deployment:
        taken = (*self.hosts, *self.services, self.localiser)
        problems = self._host_problems() + people_problems(self.people, self.router, taken)
        if self.localiser in self.services:
            problems.append(
                f"localiser: {self.localiser!r} is a service of this file; a localiser is a "
                "process of your own, with a name of its own"
            )
        for name, owner in ((OPERATOR, "tools have"), (ROUTER, "the router itself has")):
            if name in (*self.services, *self.people, self.localiser):
                problems.append(f"{self._place(name)}: {owner} this name; give another one")
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _host_problems(self) -> list[str]:
        if not self.hosts and self.router is None:
            return service_problems(self.services, (), not self.open_access)
        if not self.hosts or self.router is None:
            missing = "hosts" if not self.hosts else "router"
            return [f"{missing}: missing; hosts and router go together"]
        problems = host_problems(self.hosts, self.router, not self.open_access)
        problems += service_problems(self.services, self.hosts, not self.open_access)
        names = {self._place(name): common_name(self.keys, name) for _, name in self.certified}
        return problems + long_names(names, COMMON_NAME_MAX)

    def _place(self, name: str) -> str:
        return place_of(name, self.services, self.people, self.localiser)

    @property
    def keys(self) -> Keys:
        """The keys of this robot in this namespace."""
        return Keys(self.id, self.namespace)

    @property
    def open_access(self) -> str:
        """A warning where whoever reaches a service may do anything; else ""."""
        if self.access == "closed":
            return ""
        said = "access is open, as its file says: whoever reaches a service may move the robot"
        return said + "; no certificate proves its people" * bool(self.people)

    @property
    def parties(self) -> Parties:
        """Everybody who may have a session, and what they are."""
        roles = {name: spec.role for name, spec in self.services.items()}
        ordered = sorted(roles, key=lambda name: DIAL_ORDER.index(roles[name]))
        people = self.people if self.router is not None and not self.open_access else ()
        others: dict[str, Role] = {self.localiser: "localiser"} if self.localiser else {}
        others |= dict.fromkeys((OPERATOR, *people), "operator")
        services = {name: roles[name] for name in ordered}
        return Parties(self.keys, services, others, people)

    @property
    def certified(self) -> list[tuple[str, str]]:
        """Host and name of everybody who has a certificate: tools on each host, people on none."""
        if self.router is None or self.open_access:
            return []
        people = self.parties.people
        return [
            (self.router.host, ROUTER),
            *((spec.host, name) for name, spec in self.services.items()),
            *((host, n) for host in self.hosts for n in self.parties.others if n not in people),
            *((person, person) for person in people),
        ]

    def where(self, *place: int | str) -> str:
        """``file:line:column: `` of a place in the file it was read from; "" without a file."""
        return "" if self._file is None else locator(self._file)(place)

    def who(self, service: str, key: str) -> str:
        """What complains about a key of a service, behind its line: ``service hal: run``."""
        return f"{self.where('services', service, key)}service {service}: {key}"

    def endpoints(self, service: str) -> Endpoints:
        """Endpoints of one named service.

        Raises:
            ConfigError: no such service, password or certificate; others can reach its socket.
        """
        if service not in self.services:
            raise ConfigError(expected("deployment", "a service", repr(service), self.services))
        if self.router is not None:
            return self.tool_endpoints(service)
        before = [self.listen(name) for name in self.parties.before(service)]
        return Endpoints([self.listen(service)], before, access=self._access(service))

    def listen(self, service: str) -> str:
        """Where a service listens; "" for a client of the router.

        Raises:
            ConfigError: others can reach its socket, or it cannot be made.
        """
        if self.router is not None:
            return ""
        return self.services[service].listen or socket_endpoint(self.keys, service)

    def tool_endpoints(self, party: str = OPERATOR) -> Endpoints:
        """Endpoints of what listens nowhere and connects to every service.

        Args:
            party: who it is: a tool, the localiser, or a service in whose place it stands.

        Raises:
            ConfigError: there is no such party, password or certificate that can be used.
        """
        if self.router is not None:
            return Endpoints(
                connect=[self.router_endpoint],
                mode="client",
                router_host=self.router.host,
                access=self._access(party),
            )
        connect = [self.listen(name) for name in self.services if name != party]
        return Endpoints(connect=connect, access=self._access(party))

    def _access(self, party: str) -> dict[str, Any]:
        if self.open_access:
            return {}
        parties = self.parties
        if party not in parties.names:
            raise ConfigError(expected(f"deployment {self.id}", "a party", party, parties.names))
        if self.router is not None:
            hosts = [host for host, name in self.certified if name == party]
            return client_access(parties, party, hosts)
        secrets = find_secrets(self.keys, parties.names)
        return session_access(parties, party, secrets)

    @property
    def router_endpoint(self) -> str:
        """Where the router listens and its clients find it.

        Raises:
            ConfigError: if the deployment has no router.
        """
        router, protocol = self.routed, "tcp" if self.open_access else "tls"
        return endpoint_of(protocol, self.hosts[router.host], router.port)

    @property
    def routed(self) -> RouterSpec:
        """Where its router is.

        Raises:
            ConfigError: if the deployment has none.
        """
        if self.router is None:
            what = "has no router: its services are peers on one host; see docs/hosts.md"
            raise ConfigError(f"deployment {self.id}: {what}")
        return self.router

    def processes(self, host: str | None) -> list[str]:
        """What is started on one host, the router first where it lives; without hosts: everything.

        All but a HAL that somebody else starts.
        """
        first = [ROUTER] if self.router is not None and self.router.host == host else []
        services = self.services.items()
        here = [n for n, one in services if one.host == (host or "") and one.run != EXTERNAL]
        return first + here

    def with_host(self, service: str) -> str:
        """A service's name, with its host's where there are hosts: ``runner (host gpu)``."""
        spec = self.services.get(service)
        return f"{service} (host {spec.host})" if spec is not None and spec.host else service

    @property
    def hal(self) -> str:
        """Name of the one service that is a HAL, whichever it is."""
        found = [f"{name} ({spec.what})" for name, spec in self.services.items() if spec.is_hal]
        if len(found) != 1:
            got = ", ".join(found) or "none"
            raise ConfigError(
                f"deployment {self.id}: expected exactly one HAL, got {got}; "
                f"run names one of {', '.join(OWN_SERVICES)}, or a HAL ({HALS.choices()}; or "
                f"{EXTERNAL})"
            )
        return next(name for name, spec in self.services.items() if spec.is_hal)

    def only(self, kind: str) -> str:
        """Name of the one service that runs ``kind``.

        Raises:
            ConfigError: none or several do.
        """
        names = self._running(kind)
        if len(names) != 1:
            got = ", ".join(names) or "none"
            raise ConfigError(f"deployment {self.id}: expected exactly one {kind}, got {got}")
        return names[0]

    @property
    def runners(self) -> list[str]:
        """Names of the services that run skills, if any; each name is a source in keys."""
        return self._running("skill_runner")

    def _running(self, kind: str) -> list[str]:
        return [name for name, spec in self.services.items() if spec.run == kind]


def load_deployment(path: Path) -> Deployment:
    """Read and check a deployment file.

    Raises:
        ConfigError: naming the file and each field that does not fit.
    """
    read = load_yaml(path, Deployment)
    services = {name: spec.started_from(path.parent) for name, spec in read.services.items()}
    deployment = read.model_copy(update={"services": services})
    deployment._file = path.absolute()
    return deployment
