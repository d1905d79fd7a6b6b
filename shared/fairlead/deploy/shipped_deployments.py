"""The deployment files of this installation, those of packages included."""

from __future__ import annotations

from collections.abc import Iterator

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError
from fairlead.paths import deployment_files


def shipped_deployments(robot: str) -> Iterator[tuple[str, Deployment]]:
    """Each deployment of one robot, with its name, those that ship first.

    A file that does not load is left out: `fairlead up` says what is wrong with it.
    """
    for path in deployment_files():
        try:
            deployment = load_deployment(path)
            _ = deployment.hal  # a file without one is left out too
        except ConfigError:
            continue
        if deployment.robot == robot:
            yield path.stem, deployment
