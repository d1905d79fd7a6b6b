"""One service of a deployment file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, field_validator, model_validator

from fairlead.deploy.access import Role
from fairlead.errors import ConfigError
from fairlead.keys import check_name

_ROLES: dict[str, Role] = {
    "safety": "safety",
    "state_assembler": "state_assembler",
    "skill_runner": "runner",
}
OWN_SERVICES = tuple(_ROLES)
"""What ``run`` may name besides a HAL."""

EXTERNAL = "external"
"""``run`` of a HAL that somebody else starts, whatever it is."""


def _check_service_name(name: str) -> str:
    try:
        check_name("service", name)
    except ConfigError as error:
        raise ValueError(str(error)) from None
    if name == "up":
        raise ValueError("up: the supervisor's log has this name; give it another one")
    return name


ServiceName = Annotated[str, AfterValidator(_check_service_name)]
"""One that fits a key, and is not the log's of ``up``."""


class ServiceSpec(BaseModel):
    """One process: what it runs, where it is, and its own options.

    Attributes:
        run: a service of fairlead's, a HAL that an installed package registers in
            ``fairlead.hals``, or `EXTERNAL`.
        command: instead of ``run``, a program that is a HAL. It gets ``--deployment``,
            ``--service`` and ``--state-dir``; ``python`` is the interpreter fairlead runs in, and
            words that begin with ``./`` or ``../`` are paths from the deployment file's folder.
        listen: where access is open, its TCP endpoint for whoever reaches that; else "".
        host: the host it runs on, where there is a router; else "".
        realtime_priority: 1 (low) to 99 of the kernel's ``SCHED_FIFO``; 0: an ordinary process.
        options: checked by the service that reads it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    run: str = ""
    command: tuple[str, ...] = ()
    listen: str = ""
    host: str = ""
    realtime_priority: int = Field(default=0, ge=0, le=99)
    options: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _runs_one_thing(self) -> ServiceSpec:
        if bool(self.run) == bool(self.command):
            got = "both" if self.run else "neither"
            raise ValueError(f"expected run or command, got {got}")
        if self.run == EXTERNAL and self.realtime_priority:
            raise ValueError(f"realtime_priority: run is {EXTERNAL}: for who starts it to give")
        return self

    @property
    def is_hal(self) -> bool:
        """Whether it is the robot's HAL: what is no service of fairlead's is one."""
        return self.role == "hal"

    @property
    def role(self) -> Role:
        """What it is to the others."""
        return _ROLES.get(self.run, "hal")

    @property
    def what(self) -> str:
        """What it runs, in a word or a command line."""
        return self.run or " ".join(self.command)

    def started_from(self, folder: Path) -> ServiceSpec:
        """The same with its command's paths from a folder made absolute."""
        command = [
            str((folder / word).resolve()) if word.startswith(("./", "../")) else word
            for word in self.command
        ]
        return self.model_copy(update={"command": tuple(command)})

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
