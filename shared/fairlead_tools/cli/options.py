"""What several commands have on their command lines: the deployment, the robot, an example."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.registry import Registry, Running
from fairlead.errors import ConfigError, FairleadError, expected
from fairlead.operate.connection import choose_file, file_of, nothing_runs
from fairlead.paths import deployment_names, deployment_path, robot_ids
from fairlead.skill.manifest import skill_ids

EXIT_CODES = (
    "Exit codes: 0 it worked, 1 refused or failed, 2 wrong command line, 130 interrupted (Ctrl-C)."
)


Command = Callable[..., None]
_EXAMPLES: dict[Command, str] = {}
_NEGATIVE: set[Command] = set()
_BELOW_ZERO = re.compile(r"-[\d.]")


class _Signed(TyperCommand):
    """Takes numbers below zero as arguments, where they would be read as options."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        signed = [f" {one}" if _BELOW_ZERO.match(one) else one for one in args]
        return super().parse_args(ctx, signed)


def example(line: str, negative: bool = False) -> Callable[[Command], Command]:
    """Say how a command is typed; its help ends with that.

    Args:
        negative: an argument may be a number below zero, which gets a space before its sign.
    """

    def remember(command: Command) -> Command:
        _EXAMPLES[command] = line
        if negative:
            _NEGATIVE.add(command)
        return command

    return remember


def add_commands(app: typer.Typer, commands: Mapping[str, Command]) -> None:
    """Add commands by name, each with its example under the help text."""
    for name, command in commands.items():
        app.command(
            name=name,
            epilog=f"Example: {_EXAMPLES[command]}  --  {EXIT_CODES}",
            cls=_Signed if command in _NEGATIVE else None,
        )(command)


def make_group(name: str, text: str, commands: Mapping[str, Command]) -> typer.Typer:
    """A named group of commands."""
    group = typer.Typer(name=name, help=text, no_args_is_help=True, epilog=EXIT_CODES)
    add_commands(group, commands)
    return group


MAX_NUMBER = 2**64 - 1  # an unsigned 64-bit integer


def complete_skill(incomplete: str) -> list[str]:
    """Skills that ship or are installed."""
    try:
        return _beginning(incomplete, skill_ids())
    except FairleadError:
        return []


def complete_robot(incomplete: str) -> list[str]:
    """Robots that ship and the user's own."""
    try:
        return _beginning(incomplete, robot_ids())
    except FairleadError:
        return []


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def parse_deployment(wanted: str) -> Path:
    """A deployment file given by its path or its name in compose/."""
    return _parsed(deployment_path, wanted)


def parse_running_or_file(wanted: str) -> Path:
    """The file of a deployment that runs here, by its name in `fairlead ps`, or as above."""
    return _parsed(file_of, wanted)


def _parsed(find: Callable[[str], Path], wanted: str) -> Path:
    try:
        return find(wanted)
    except ConfigError as error:
        raise typer.BadParameter(str(error)) from None


def _complete_running(incomplete: str) -> list[str]:
    return [entry.name for entry in Registry().entries() if entry.name.startswith(incomplete)]


def _complete_deployment(incomplete: str) -> list[str]:
    return [name for name in deployment_names() if name.startswith(incomplete)]


_ONLY_ONE = "the only one that runs here"


def deployment_option(*names: str, what: str = "", without: str = _ONLY_ONE) -> Any:
    """Which deployment: an option with these ``names``, or an argument.

    Args:
        what: what the command does with it.
        without: which it is where none is named.
    """
    parameter = typer.Option if names else typer.Argument
    which = "as in `fairlead ps`, a name in compose/, or a file"
    return parameter(
        *names,
        parser=parse_running_or_file,
        metavar="NAME_OR_FILE",
        help=f"{what}{which}; without it: {without}",
        autocompletion=lambda incomplete: [
            *_complete_running(incomplete),
            *_complete_deployment(incomplete),
        ],
    )


DeploymentOption = Annotated[Path | None, deployment_option("--deployment", "-d")]
DeploymentArgument = Annotated[
    Path,
    typer.Argument(
        parser=parse_deployment,
        metavar="NAME_OR_FILE",
        help="a name in compose/, or a file",
        autocompletion=_complete_deployment,
    ),
]
DeploymentsArgument = Annotated[
    list[Path],
    typer.Argument(
        parser=parse_deployment,
        metavar="NAME_OR_FILE",
        help="names in compose/, or files",
        autocompletion=_complete_deployment,
    ),
]
_RUNNING_HELP = f"as in `fairlead ps`, or its file; without it: {_ONLY_ONE}"
RunningArgument = Annotated[
    str | None,
    typer.Argument(metavar="NAME_OR_FILE", help=_RUNNING_HELP, autocompletion=_complete_running),
]
RunningOption = Annotated[
    str | None,
    typer.Option(
        "--deployment",
        "-d",
        metavar="NAME_OR_FILE",
        help=_RUNNING_HELP,
        autocompletion=_complete_running,
    ),
]
StateDirOption = Annotated[
    Path | None,
    typer.Option(
        file_okay=False,
        help="folder for logs and state; default: a folder of the deployment's name in "
        "$FAIRLEAD_STATE, else in ~/.local/state/fairlead",
    ),
]
NewStateOption = Annotated[
    bool,
    typer.Option(
        "--new-state",
        help="the gate's state folder is new and that is right; with profile hardware it "
        "latches without it",
    ),
]
WithoutOption = Annotated[
    list[str] | None,
    typer.Option(
        help="a service (or router) that somebody else runs: fairlead service; repeatable"
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="print one JSON document instead")]


def naming(file: Path) -> str:
    """What stands behind an advised command: the deployment, where more than one runs here."""
    return f" --deployment {shlex.quote(str(file))}" if len(Registry().entries()) > 1 else ""


def choose_deployment(file: Path | None) -> Deployment:
    """The deployment a command is about.

    Raises:
        ConfigError: several run.
        NoAnswerError: none runs, naming those that can be started.
    """
    return load_deployment(choose_file(file))


def left_out(deployment: Deployment, without: list[str] | None) -> list[str]:
    """What `WithoutOption` names.

    Raises:
        ConfigError: the file has no such service.
    """
    known = [*deployment.services, *([ROUTER] if deployment.router else [])]
    for name in without or ():
        if name not in known:
            raise ConfigError(expected("--without", "a service of the file", repr(name), known))
    return without or []


def choose_running(wanted: str | None) -> Running:
    """A deployment that was started on this machine, by name or file.

    Raises:
        ConfigError: several run and none was named, or the one named does not.
        NoAnswerError: none runs, naming those that can be started.
    """
    running = Registry().entries()
    names = ", ".join(entry.name for entry in running)
    if not running:
        raise nothing_runs()
    if wanted is None:
        if len(running) > 1:
            raise ConfigError(f"several deployments run here; name one of: {names}")
        return running[0]
    found = [entry for entry in running if entry.name == wanted] or [
        entry for entry in running if _is_file_of(wanted, entry)
    ]
    if not found:
        raise ConfigError(f"no deployment {wanted!r} runs here (valid: {names})")
    if len(found) > 1:
        names = ", ".join(entry.name for entry in found)
        raise ConfigError(f"{wanted} runs here more than once; name one of: {names}")
    return found[0]


def _is_file_of(wanted: str, entry: Running) -> bool:
    try:
        return deployment_path(wanted).resolve() == Path(entry.deployment).resolve()
    except ConfigError:
        return False


_HELP = "folder under robots/"
RobotArgument = Annotated[str, typer.Argument(help=_HELP, autocompletion=complete_robot)]
RobotOption = Annotated[str, typer.Option(help=_HELP, autocompletion=complete_robot)]
SkillArgument = Annotated[
    str,
    typer.Argument(
        metavar="NAME_OR_FOLDER",
        autocompletion=complete_skill,
        help="a skill that ships or is installed (fairlead skill ls), or a folder with rskill.yaml",
    ),
]
