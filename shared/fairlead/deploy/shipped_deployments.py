"""The deployment files of this installation."""

from __future__ import annotations

from collections.abc import Iterator

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError
from fairlead.paths import repo_root


def shipped_deployments(robot: str) -> Iterator[tuple[str, Deployment]]:
    """Each deployment in ``compose/`` of one robot, with its name, in the order of names.

    A file that does not load is left out: `fairlead up` says what is wrong with it.
    """
    for path in sorted((repo_root() / "compose").glob("*.yaml")):
        try:
            deployment = load_deployment(path)
            _ = deployment.hal  # a file without one is left out too
        except ConfigError:
            continue
        if deployment.robot == robot:
            yield path.stem, deployment
