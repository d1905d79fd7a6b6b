"""``fairlead ps``, ``logs``, ``down``: the processes of deployments on this machine."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Annotated

import msgspec
import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.deploy.process_table import ProcessId
from fairlead.deploy.registry import Registry, Running, ServiceEntry, running_name
from fairlead.errors import (
    ConfigError,
    FairleadError,
    NoAnswerError,
    ServiceError,
    TransportError,
    expected,
)
from fairlead.log_stamp import STAMP_LENGTH
from fairlead.operate.client import RobotClient, alive_services
from fairlead.operate.connection import nothing_runs
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.options import (
    DeploymentOption,
    JsonOption,
    RunningArgument,
    RunningOption,
    choose_running,
    example,
)
from fairlead_tools.deploy.systemd_units import unit_name
from fairlead_tools.supervisor.service_log import LogReader


@example("fairlead ps")
def ps_command(deployment: DeploymentOption = None, as_json: JsonOption = False) -> None:
    """List the deployments started on this machine and their processes.

    Also services that are seen on the network but were started elsewhere: of these
    deployments, or of the one named.
    """
    entries = _entries(deployment)
    seen = {entry.name: _alive(entry) for entry in entries if not _is_whole(entry)}
    if as_json:
        print_json([_document(entry, seen.get(entry.name, frozenset())) for entry in entries])
        return
    rows = [row for entry in entries for row in _rows(entry, seen.get(entry.name, frozenset()))]
    if not rows:
        echo(str(nothing_runs()))
        return
    print_table(("DEPLOYMENT", "SERVICE", "PID", "STATE", "RESTARTS"), rows)
    for entry in entries:
        if entry.supervisor is not None and not entry.is_supervised:
            echo(f"{entry.name}: its supervisor is gone; clean up: fairlead down {entry.name}")


def _entries(file: Path | None) -> list[Running]:
    """What was started here; with a file: of that deployment, an empty entry if nothing was."""
    entries = Registry().entries()
    if file is None:
        return entries
    same = [entry for entry in entries if Path(entry.deployment).resolve() == file.resolve()]
    return same or [Running(running_name(load_deployment(file)), str(file), "", None)]


def _is_whole(entry: Running) -> bool:
    """Whether a supervisor knows all there is to know: nothing to ask the network."""
    return (
        entry.is_supervised
        and not entry.by_hand
        and set(_file_services(entry)) <= set(entry.services)
    )


def _file_services(entry: Running) -> list[str]:
    try:
        return list(load_deployment(Path(entry.deployment)).services)
    except ConfigError:  # edited or deleted since
        return []


def _alive(entry: Running) -> frozenset[str]:
    try:
        return alive_services(load_deployment(Path(entry.deployment)))
    except (ConfigError, TransportError):  # edited since, or its router is away
        return frozenset()


def _rows(entry: Running, alive: frozenset[str]) -> list[tuple[object, ...]]:
    rows: list[tuple[object, ...]] = [
        (entry.name, name, _pid(service), _state(entry, name, service, alive), service.restarts)
        for name, service in entry.services.items()
    ]
    return rows + [
        (entry.name, name, "-", "elsewhere", "-") for name in sorted(alive - set(entry.services))
    ]


def _document(entry: Running, alive: frozenset[str]) -> object:
    document = msgspec.to_builtins(entry)
    document["supervised"] = entry.is_supervised
    document["elsewhere"] = sorted(alive - set(entry.services))
    for name, service in entry.services.items():
        document["services"][name]["state"] = _state(entry, name, service, alive)
    return document


def _pid(service: ServiceEntry) -> str:
    return str(service.process.pid) if service.process is not None else "-"


def _state(entry: Running, name: str, service: ServiceEntry, alive: frozenset[str]) -> str:
    if service.by_hand:
        return "ready, by hand" if name in alive else "starting, by hand"
    if service.process is None:
        return "waiting" if entry.is_supervised else "dead"
    if service.running is None:
        return "restarting" if entry.is_supervised else "dead"
    if not entry.is_supervised:
        return "left over"
    return "ready" if service.ready else "starting"


FOLLOW_S = 0.2
BY_HAND = "a service started by hand prints in the terminal (or unit) that started it"


@example("fairlead logs hal -n 50 -f")
def logs_command(
    service: Annotated[str | None, typer.Argument(help="one service; all without it")] = None,
    deployment: RunningOption = None,
    lines: Annotated[int, typer.Option("-n", "--lines", min=1, help="newest lines of each")] = 20,
    state_dir: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help="state folder of a run that has ended"),
    ] = None,
    follow: Annotated[
        bool, typer.Option("-f", "--follow", help="go on with what is added, until Ctrl-C")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Print the newest log lines of a deployment's services, in order of time."""
    if follow and as_json:
        raise ConfigError("logs: --json prints one document, so it cannot --follow")
    entry = _running(deployment) if state_dir is None else None
    folder = (state_dir or Path(entry.state_dir if entry else "")) / "logs"
    started = entry.services.items() if entry is not None else ()
    listed = {name for name, one in started if not one.by_hand}  # also what has not printed yet
    known = sorted(listed | _names_of_logs(folder))
    by_hand = entry.by_hand if entry is not None else {}
    if service in by_hand or (by_hand and not known):
        raise ConfigError(f"logs: {service or ', '.join(by_hand)}: {BY_HAND}")
    if not known:
        raise ConfigError(f"logs: no *.log in {folder}; is that a state folder of `fairlead up`?")
    if service is not None and service not in known:
        ran = expected("logs", "a service that `fairlead up` ran", repr(service), known)
        raise ConfigError(f"{ran}; {BY_HAND}")
    with ExitStack() as stack:
        readers: dict[str, LogReader] = {}

        def read(names: Iterable[str]) -> None:
            for name in names:
                if name not in readers:
                    reader = LogReader(folder / f"{name}.log")
                    readers[name] = stack.enter_context(closing(reader))

        read(known if service is None else [service])
        newest = {one: reader.newest(lines) for one, reader in readers.items()}
        if as_json:
            print_json(newest)
            return
        _print(newest)
        while follow:
            time.sleep(FOLLOW_S)
            if service is None:
                read(sorted(_names_of_logs(folder)))
            _print({one: reader.more() for one, reader in readers.items()})


def _names_of_logs(folder: Path) -> set[str]:
    return {path.stem for path in folder.glob("*.log")}


def _running(deployment: str | None) -> Running:
    try:
        return choose_running(deployment)
    except NoAnswerError as error:
        raise NoAnswerError(
            f"{error}; of a run that has ended: fairlead logs --state-dir DIR; {BY_HAND}"
        ) from None


def _print(lines: Mapping[str, Sequence[str]]) -> None:
    """In order of time, which every line begins with."""
    in_order = sorted(
        ((line, service) for service, texts in lines.items() for line in texts),
        key=lambda one: one[0][:STAMP_LENGTH],
    )
    for line, service in in_order:
        echo(f"[{service}] {line}")


SUPERVISOR_GRACE_S = 15.0  # its own grace for the services, and a margin
SERVICE_GRACE_S = 3.0
POLL_S = 0.05


@example("fairlead down panda_mobile")
def down_command(name: RunningArgument = None, deployment: RunningOption = None) -> None:
    """Stop a deployment that runs on this machine, and wait until its processes are gone.

    Ends what `fairlead up` and `fairlead service` started.
    """
    if name and deployment:
        raise ConfigError(f"down: expected one deployment, got {name} and {deployment}")
    entry = choose_running(name or deployment)
    managed = [name for name, service in entry.by_hand.items() if service.managed]
    if managed:
        robot, _, namespace = entry.name.partition("@")
        unit = unit_name(robot.partition(":")[0], namespace or "fl")
        raise ServiceError(
            f"{entry.name}: systemd would start {', '.join(managed)} again; end what it runs: "
            f"sudo systemctl stop {unit}.target"
        )
    if entry.supervisor is not None:
        end_processes([entry.supervisor], SUPERVISOR_GRACE_S)
        _check_gone(entry.name, [entry.supervisor])
    if entry.by_hand:
        _disarm(entry)
    left, by_hand = _leftovers(entry)
    if left:
        end_processes(left, SERVICE_GRACE_S)
    _check_gone(entry.name, left)
    Registry().remove_if_ended(entry.name)
    others = len(left) - len(by_hand)
    ended = [f"{', '.join(by_hand)} (started by hand)"] if by_hand else []
    ended += [f"{others} leftover process{'es' * (others > 1)}"] if others else []
    echo(" and ".join([f"stopped {entry.name}", *ended]))
    for lock in Path(entry.state_dir).glob("*/gate.lock"):
        if not lock.with_name("clean_mark").exists():
            echo(
                f"its last gate ({lock.parent.name}) did not end disarmed: it will start latched, "
                "until fairlead reset"
            )


def end_processes(processes: list[ProcessId], grace_s: float) -> None:
    """SIGTERM, then SIGKILL to those still there after the grace."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        for process in processes:
            process.send(number)
        deadline = time.monotonic() + grace_s
        while any(p.is_running for p in processes) and time.monotonic() < deadline:
            time.sleep(POLL_S)


def _leftovers(entry: Running) -> tuple[list[ProcessId], list[str]]:
    """What still runs, by the newest word: a supervisor starts processes until it ends.

    And which of it somebody started by hand.
    """
    newest = Registry().find(entry.name)
    if newest is None or newest.is_supervised:  # the latter: started again by somebody else
        return [], []
    return newest.leftovers, list(newest.by_hand)


def _disarm(entry: Running) -> None:
    """End claims before the processes, so that a gate started by hand ends cleanly too."""
    try:
        with RobotClient(load_deployment(Path(entry.deployment)), by="fairlead down") as client:
            client.disarm()
    except FairleadError:  # no gate, or one that is not armed: nothing to end
        return


def _check_gone(name: str, processes: list[ProcessId]) -> None:
    still = [str(process.pid) for process in processes if process.is_running]
    if still:
        numbers = " ".join(still)
        raise ServiceError(f"{name}: could not end pid {numbers}; try: kill -9 {numbers}")
