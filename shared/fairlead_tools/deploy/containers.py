"""A compose file: each process of a host in a container of its own, with few rights."""

from __future__ import annotations

from collections.abc import Container
from pathlib import Path
from typing import Any

import yaml

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.errors import ConfigError

HOME = "/var/lib/fairlead"
"""In each container: passwords, certificates, logs, own robots and skills."""
FILE = "/etc/fairlead/deployment.yaml"
STOP_S = 15

_HEAD = """\
# Written by `fairlead deploy containers`. The image is made by compose/Containerfile.
#   podman: USER_ID=$(id -u) USERNS=keep-id podman-compose up --detach
#   docker: USER_ID=$(id -u) docker compose up --detach
# A HAL that needs a serial port, a runner that needs a GPU: give it `devices:`.
"""


def compose_file(
    file: Path, deployment: Deployment, host: str | None, image: str, without: Container[str] = ()
) -> str:
    """Text of the compose file for one host.

    The containers share the host's network, because services of a host meet on its loopback, and
    one folder, `state` beside the file, which holds what proves their names. None waits for
    another one: the gate and the HAL go on whatever becomes of the rest.

    Args:
        file: the deployment file, where it lies on that host.
        host: a host of the file; None where it has none.
        image: what compose/Containerfile was built as.
        without: processes that get none.

    Raises:
        ConfigError: the file's path has signs that mean something else in a compose file.
    """
    names = [name for name in deployment.processes(host) if name not in without]
    return _HEAD + yaml.safe_dump(
        {
            "name": f"fairlead-{deployment.id}".lower(),
            "x-podman": {"in_pod": False},  # in a pod it refuses `userns_mode`
            "services": {name: _service(file, deployment, name, image) for name in names},
        },
        sort_keys=False,
    )


def _service(file: Path, deployment: Deployment, name: str, image: str) -> dict[str, Any]:
    spec = deployment.services.get(name)
    limits = {"core": 0}
    if spec is not None and spec.realtime_priority:
        limits["rtprio"] = spec.realtime_priority
    return {
        "image": image,
        "command": ["router", FILE] if name == ROUTER else ["service", FILE, name],
        "network_mode": "host",
        "user": "${USER_ID:?the number of the user who owns the folder state}",
        "userns_mode": "${USERNS:-}",
        "environment": {"HOME": HOME},
        "volumes": [f"{_path(file)}:{FILE}:ro", f"./state:{HOME}"],
        "read_only": True,
        "tmpfs": ["/tmp"],  # noqa: S108  # its own
        "cap_drop": ["ALL"],
        "security_opt": ["no-new-privileges:true"],
        "ulimits": limits,
        "restart": "always",
        "stop_grace_period": f"{STOP_S}s",
    }


def _path(file: Path) -> str:
    path = str(file.absolute())
    if any(sign in path for sign in ":$\n"):
        raise ConfigError(f"compose file: {path}: expected a path without colons and $")
    return path
