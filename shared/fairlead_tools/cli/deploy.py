"""``fairlead deploy``: a deployment on all its hosts, before it starts."""

from __future__ import annotations

import pwd
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError, ServiceError, expected
from fairlead.paths import written
from fairlead_tools.cli.console import ProgressLine, echo, print_json
from fairlead_tools.cli.options import (
    DeploymentsArgument,
    JsonOption,
    WithoutOption,
    example,
    left_out,
    make_group,
)
from fairlead_tools.deploy.all_hosts import ask_host, compare, peer_problems, router_problems
from fairlead_tools.deploy.containers import compose_file, router_compose_file
from fairlead_tools.deploy.host_report import HostReport, report_this
from fairlead_tools.deploy.systemd_units import router_unit, systemd_units

HostOption = Annotated[str | None, typer.Option(help="which host of the file, if it has several")]


@example("fairlead deploy check ./panda_mobile_two_hosts.yaml")
def check_command(
    deployments: DeploymentsArgument,
    host: Annotated[
        str | None, typer.Option(help="only this machine, as this host of the file")
    ] = None,
    reach: Annotated[
        str, typer.Option(help="how to run a command on another host; {address} is its address")
    ] = "ssh -o BatchMode=yes -o ConnectTimeout=5 {address}",
    program: Annotated[
        str, typer.Option("--program", help="how fairlead is called on other hosts")
    ] = "fairlead",
    as_json: JsonOption = False,
) -> None:
    """Find what is wrong on all hosts before anything starts; nothing is started or moved.

    Addresses, ports, certificates, versions, robots, skills, the gate's file. The file has the same
    path on all hosts, which are asked by ssh; those that cannot be asked are a problem. Several
    files: also whether these robots can share their routers, or this machine. Exits with 1 if there
    is a problem.
    """
    every = [load_deployment(file) for file in deployments]
    problems = [*router_problems(every), *peer_problems(every)]
    reports: list[HostReport] = []
    for file, loaded in zip(deployments, every, strict=True):
        _ = loaded.hal, loaded.only("safety")
        found: list[HostReport] = []
        if host is not None or not loaded.hosts:
            found = [report_this(file, loaded, host)]
        else:
            with ProgressLine(quiet=as_json) as line:
                for name in loaded.hosts:
                    line.show(f"asking host {name}")
                    try:
                        found.append(ask_host(file, loaded, name, reach, program))
                    except ServiceError as error:
                        problems.append(str(error))
            if found:
                problems += compare(loaded, found)
        reports += found
        if not as_json:
            _say(loaded.id if len(every) > 1 else "", found)
    if as_json:
        print_json({"hosts": [one.model_dump() for one in reports], "problems": problems})
    else:
        for text in problems:
            echo(f"PROBLEM {text}")
    if problems or any(one.problems for one in reports):
        raise typer.Exit(1)


def _say(robot: str, reports: list[HostReport]) -> None:
    for one in reports:
        where = ", ".join(filter(None, (robot, one.host and f"host {one.host}")))
        where = f"{where}: " if where else ""
        found = f"problems: {len(one.problems)}" if one.problems else "ready to start"
        echo(
            f"{where}{found}; {', '.join(one.processes) or 'nothing runs here'}; fairlead "
            f"{one.versions['fairlead']}, robot {one.robot or 'unknown'}, {len(one.skills)} skills"
        )
        for text in one.warnings:
            echo(f"  {text}")
        for text in one.problems:
            echo(f"  PROBLEM {text}")


@example("fairlead deploy units ./panda_mobile_two_hosts.yaml --host robot --out units")
def units_command(
    deployments: DeploymentsArgument,
    out: Annotated[Path, typer.Option(help="folder for them; it is made")],
    host: HostOption = None,
    user: Annotated[str, typer.Option(help="as whom the services run")] = "fairlead",
    without: WithoutOption = None,
) -> None:
    """Write units for systemd: each process of a host by itself, watched, with few rights.

    Several files: the unit of the router that these robots share.
    """
    if len(deployments) == 1:
        loaded, host = _on_host(deployments[0], host)
        leave_out = left_out(loaded, without)
        units = systemd_units(deployments[0], loaded, host, user, leave_out)
    else:
        units = router_unit(deployments, _sharing(deployments, host, without), user)
    out.mkdir(parents=True, exist_ok=True)
    for name, text in units.items():
        with written(out / name, out / name):
            (out / name).write_text(text, encoding="utf-8")
        echo(str(out / name))
    first = next(iter(units))
    try:
        pwd.getpwnam(user)
    except KeyError:
        echo(f"make the user: useradd --system {user}")
    echo(f"copy them to /etc/systemd/system, then: systemctl enable --now {' '.join(units)}")
    echo(f"to stop all: systemctl stop {first}")
    home = f"/var/lib/{Path(first).stem.replace(':', '+')}"
    echo(f"certificates, skills, robots: below {home}/.local, the home of all these services")
    echo(f"commands there: sudo -u {user} HOME={home} fairlead status")


@example("fairlead deploy containers ./panda_mobile_two_hosts.yaml --host robot --out containers")
def containers_command(
    deployments: DeploymentsArgument,
    out: Annotated[Path, typer.Option(help="folder for compose.yaml; it is made")],
    host: HostOption = None,
    image: Annotated[
        str, typer.Option(help="what compose/Containerfile was built as")
    ] = "localhost/fairlead",
    without: WithoutOption = None,
) -> None:
    """Write a compose file: each process of a host in a container of its own, with few rights.

    Several files: that of the router that these robots share.
    """
    if len(deployments) == 1:
        loaded, host = _on_host(deployments[0], host)
        text = compose_file(deployments[0], loaded, host, image, left_out(loaded, without))
    else:
        text = router_compose_file(deployments, _sharing(deployments, host, without), image)
    (out / "state").mkdir(parents=True, exist_ok=True, mode=0o700)
    file = out / "compose.yaml"
    with written(file, file):
        file.write_text(text, encoding="utf-8")
    echo(str(file))
    echo("how to start it is said at its beginning")


def _sharing(
    files: Sequence[Path], host: str | None, without: Sequence[str] | None
) -> list[Deployment]:
    """Deployments whose router is meant, and nothing else of them.

    Raises:
        ConfigError: options that are of one file.
    """
    if host or without:
        raise ConfigError("--host, --without: expected one file with them, got several")
    return [load_deployment(file) for file in files]


def _on_host(file: Path, host: str | None) -> tuple[Deployment, str | None]:
    """A deployment and which of its hosts is meant.

    Raises:
        ConfigError: it has several, or not this one.
    """
    loaded = load_deployment(file)
    if host is None and len(loaded.hosts) == 1:
        [host] = loaded.hosts
    if (host or "") not in (loaded.hosts or {"": ""}):
        raise ConfigError(expected("--host", "a host of the file", repr(host), loaded.hosts))
    return loaded, host


group = make_group(
    "deploy",
    "Check a deployment on all its hosts before it starts; files for systemd and containers.",
    {"check": check_command, "units": units_command, "containers": containers_command},
)
