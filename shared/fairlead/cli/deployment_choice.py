"""Which deployment a command is about, and how its file is named on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError, NoAnswerError
from fairlead.paths import deployment_path, repo_root
from fairlead.supervisor import Registry, Running


def parse_deployment(wanted: str) -> Path:
    """A deployment file given by its path or its name in compose/."""
    try:
        return deployment_path(wanted)
    except ConfigError as error:
        raise typer.BadParameter(str(error)) from None


DeploymentOption = Annotated[
    Path | None,
    typer.Option(
        "--deployment",
        "-d",
        parser=parse_deployment,
        metavar="NAME_OR_FILE",
        help="without it: the only deployment that runs on this machine",
    ),
]
NameArgument = Annotated[
    str | None,
    typer.Argument(help="deployment name as in `fairlead ps`; may be left out if only one runs"),
]
JsonOption = Annotated[bool, typer.Option("--json", help="print one JSON document instead")]


def choose_deployment(file: Path | None) -> Deployment:
    """The deployment a command is about.

    Raises:
        ConfigError: several run.
        NoAnswerError: none runs, naming those that can be started.
    """
    return load_deployment(choose_file(file))


def choose_file(file: Path | None) -> Path:
    """The file of the deployment a command is about; raises as `choose_deployment` does."""
    if file is not None:
        return file
    running = sorted({entry.deployment for entry in Registry().entries()})
    if len(running) == 1:  # perhaps once for each of its hosts
        return Path(running[0])
    if running:
        files = "\n".join(f"  --deployment {file}" for file in running)
        raise ConfigError(f"several deployments run on this machine; add one of:\n{files}")
    raise nothing_runs()


def nothing_runs() -> NoAnswerError:
    """What to say where no deployment was started: how, and which there are."""
    known = ", ".join(sorted(path.stem for path in (repo_root() / "compose").glob("*.yaml")))
    return NoAnswerError(
        "no deployment runs on this machine; start one: fairlead up NAME "
        f"(valid: {known or 'none'}, or a file)"
    )


def choose_running(name: str | None) -> Running:
    """A deployment that was started on this machine.

    Raises:
        ConfigError: several run and none was named, or the name is unknown.
        NoAnswerError: none runs, naming those that can be started.
    """
    running = Registry().entries()
    names = [entry.name for entry in running]
    if not running:
        raise nothing_runs()
    if name is None:
        if len(running) > 1:
            raise ConfigError(f"several deployments run here; name one of: {', '.join(names)}")
        return running[0]
    for entry in running:
        if entry.name == name:
            return entry
    raise ConfigError(f"no deployment {name!r} runs here (valid: {', '.join(names)})")
