"""Deployment files (``compose/*.yaml``): which services run where, and how they meet."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from fairlead.errors import ConfigError
from fairlead.keys import Keys, check_name
from fairlead.session import Endpoints
from fairlead.yaml_file import load_yaml

ServiceKind = Literal["hal_sim", "hal_mujoco", "safety", "state_assembler", "skill_runner"]


class ServiceSpec(BaseModel):
    """One process: what it runs, where it listens, and its own options.

    ``options`` is checked by the service that reads it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    run: ServiceKind
    listen: str
    options: dict[str, Any] = Field(default_factory=dict)

    @field_validator("listen")
    @classmethod
    def _endpoint(cls, value: str) -> str:
        protocol, _, address = value.partition("/")
        host, _, port = address.rpartition(":")
        if protocol != "tcp" or not host or not port.isdecimal() or not 0 < int(port) < 2**16:
            raise ValueError(
                f"expected an endpoint such as tcp/127.0.0.1:7501 (port 1 to 65535), got {value!r}"
            )
        return value


class Deployment(BaseModel):
    """One robot's services on one host.

    Every service listens on its own endpoint and connects to those above it in the
    file, so that each pair has exactly one link whatever the start order.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    robot: str = Field(description="folder under robots/")
    id: str = Field(description="the robot's id in keys")
    namespace: str = "fl"
    profile: Literal["sim", "hardware"] = "sim"
    pacing: Literal["realtime", "lockstep"] = "lockstep"
    services: dict[str, ServiceSpec]

    @field_validator("id", "namespace")
    @classmethod
    def _key_chunk(cls, value: str) -> str:
        try:
            return check_name("deployment", value)
        except ConfigError as error:
            raise ValueError(str(error)) from None  # so that the file's other problems show too

    @field_validator("services")
    @classmethod
    def _endpoints_differ(cls, value: dict[str, ServiceSpec]) -> dict[str, ServiceSpec]:
        owners: dict[str, str] = {}
        for name, spec in value.items():
            other = owners.setdefault(spec.listen, name)
            if other != name:
                raise ValueError(f"{other} and {name} listen on the same endpoint {spec.listen}")
        return value

    @property
    def keys(self) -> Keys:
        """The keys of this robot in this namespace."""
        return Keys(self.id, self.namespace)

    def endpoints(self, service: str) -> Endpoints:
        """Endpoints of one named service."""
        above: list[str] = []
        for name, spec in self.services.items():
            if name == service:
                return Endpoints(listen=[spec.listen], connect=above)
            above.append(spec.listen)
        raise ConfigError(f"deployment: no service {service!r} (valid: {', '.join(self.services)})")

    def tool_endpoints(self) -> Endpoints:
        """Endpoints of a command-line tool: listens nowhere, connects to everyone."""
        return Endpoints(connect=[spec.listen for spec in self.services.values()])

    @property
    def hal(self) -> str:
        """Name of the one service that is a HAL, whichever it is."""
        names = [name for name, spec in self.services.items() if spec.run.startswith("hal_")]
        if len(names) != 1:
            raise ConfigError(f"deployment: expected exactly one HAL, got {names}")
        return names[0]

    def only(self, kind: ServiceKind) -> str:
        """Name of the one service that runs ``kind``."""
        names = [name for name, spec in self.services.items() if spec.run == kind]
        if len(names) != 1:
            raise ConfigError(f"deployment: expected exactly one {kind}, got {names}")
        return names[0]


def load_deployment(path: Path) -> Deployment:
    """Read and check a deployment file.

    Raises:
        ConfigError: naming the file and each field that does not fit.
    """
    return load_yaml(path, Deployment)
