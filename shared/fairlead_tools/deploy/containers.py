"""A compose file: each process of a host in a container of its own, with few rights."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.shared_router import check_shared
from fairlead.errors import ConfigError
from fairlead_tools.deploy.systemd_units import unit_name

HOME = "/var/lib/fairlead"
"""In each container: passwords, certificates, logs, own robots and skills."""
FILE = "/etc/fairlead/deployment.yaml"
STOP_S = 15

_HEAD = """\
# Written by `fairlead deploy containers`. The image is made by compose/Containerfile.
#   podman: USER_ID=$(id -u) USERNS=keep-id podman-compose up --detach
#   docker: USER_ID=$(id -u) docker compose up --detach
# Certificates, skills and robots go below state/.local beside this file.
# A HAL that needs a serial port, a runner that needs a GPU: give it `devices:`.
"""


def compose_file(
    file: Path, deployment: Deployment, host: str | None, image: str, without: Container[str] = ()
) -> str:
    """Text of the compose file for one host.

    The containers share one folder, `state` beside the file, where the services of a host meet and
    which holds what proves their names, and the host's network, where robots and routers are. None
    waits for another one: the gate and the HAL go on whatever becomes of the rest.

    Args:
        file: the deployment file, where it lies on that host.
        host: a host of the file; None where it has none.
        image: what compose/Containerfile was built as.
        without: processes that get none.

    Raises:
        ConfigError: the file's path has signs that mean something else in a compose file.
    """
    names = [name for name in deployment.processes(host) if name not in without]
    return _text(
        project_name(deployment.id, deployment.namespace),
        {name: _service(deployment, name, file, image) for name in names},
    )


def router_compose_file(
    files: Sequence[Path], deployments: Sequence[Deployment], image: str
) -> str:
    """Text of the compose file of a router that several robots share.

    Args:
        files: the deployment files, where they lie on the router's host.
        image: as of `compose_file`.

    Raises:
        ConfigError: as `compose_file`; they cannot share a router.
    """
    check_shared(deployments)
    mounted = {str(Path(FILE).with_stem(f"robot{n}")): file for n, file in enumerate(files, 1)}
    return _text(f"fairlead-{ROUTER}", {ROUTER: _container([ROUTER, *mounted], mounted, image)})


def project_name(robot: str, namespace: str) -> str:
    """A robot's project: no other robot's, and without the signs that a project cannot have."""
    name = unit_name(robot, namespace)
    plain = re.sub("[:.]", "-", name)
    return plain if plain == name else f"{plain}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def _text(project: str, services: Mapping[str, Any]) -> str:
    content = {
        "name": project,
        "x-podman": {"in_pod": False},  # in a pod it refuses `userns_mode`
        "services": services,
    }
    return _HEAD + yaml.safe_dump(content, sort_keys=False)


def _service(deployment: Deployment, name: str, file: Path, image: str) -> dict[str, Any]:
    spec = deployment.services.get(name)
    words = [ROUTER, FILE] if name == ROUTER else ["service", FILE, name]
    return _container(words, {FILE: file}, image, spec.realtime_priority if spec else 0)


def _container(
    words: Sequence[str], mounted: Mapping[str, Path], image: str, priority: int = 0
) -> dict[str, Any]:
    return {
        "image": image,
        "command": list(words),
        "network_mode": "host",
        "user": "${USER_ID:?the number of the user who owns the folder state}",
        "userns_mode": "${USERNS:-}",
        "environment": {"HOME": HOME},
        "volumes": [
            *(f"{_path(file)}:{inside}:ro" for inside, file in mounted.items()),
            f"./state:{HOME}",
        ],
        "read_only": True,
        "tmpfs": ["/tmp"],  # noqa: S108  # its own
        "cap_drop": ["ALL"],
        "security_opt": ["no-new-privileges:true"],
        "ulimits": {"core": 0} | ({"rtprio": priority} if priority else {}),
        "restart": "always",
        "stop_grace_period": f"{STOP_S}s",
    }


def _path(file: Path) -> str:
    path = str(file.absolute())
    if any(sign in path for sign in ":$\n"):
        raise ConfigError(f"compose file: {path}: expected a path without colons and $")
    return path
