"""``fairlead logs``: what the services printed."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.registry import Running
from fairlead.errors import ConfigError, NoAnswerError, expected
from fairlead.log_stamp import STAMP_LENGTH
from fairlead_tools.cli.console import echo, print_json
from fairlead_tools.cli.deployment_choice import JsonOption, RunningOption, choose_running
from fairlead_tools.supervisor.service_log import LogReader

EXAMPLE = "fairlead logs hal -n 50 -f"
FOLLOW_S = 0.2
BY_HAND = "a service started by hand prints in the terminal (or unit) that started it"


def command(
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
    files = {path.stem: path for path in sorted(folder.glob("*.log"))}
    by_hand = entry.by_hand if entry is not None else {}
    if service in by_hand or (by_hand and not files):
        raise ConfigError(f"logs: {service or ', '.join(by_hand)}: {BY_HAND}")
    if not files:
        raise ConfigError(f"logs: no *.log in {folder}; is that a state folder of `fairlead up`?")
    if service is not None and service not in files:
        ran = expected("logs", "a service that `fairlead up` ran", repr(service), files)
        raise ConfigError(f"{ran}; {BY_HAND}")
    wanted = [service] if service is not None else list(files)
    with ExitStack() as stack:
        readers = {one: stack.enter_context(closing(LogReader(files[one]))) for one in wanted}
        newest = {one: reader.newest(lines) for one, reader in readers.items()}
        if as_json:
            print_json(newest)
            return
        _print(newest)
        if follow:
            _follow(readers)


def _running(deployment: str | None) -> Running:
    try:
        return choose_running(deployment)
    except NoAnswerError as error:
        raise NoAnswerError(
            f"{error}; of a run that has ended: fairlead logs --state-dir DIR; {BY_HAND}"
        ) from None


def _follow(readers: Mapping[str, LogReader]) -> None:
    """Print what is added, until Ctrl-C."""
    with suppress(KeyboardInterrupt):
        while True:
            time.sleep(FOLLOW_S)
            _print({service: reader.more() for service, reader in readers.items()})


def _print(lines: Mapping[str, Sequence[str]]) -> None:
    """In order of time, which every line begins with."""
    in_order = sorted(
        ((line, service) for service, texts in lines.items() for line in texts),
        key=lambda one: one[0][:STAMP_LENGTH],
    )
    for line, service in in_order:
        echo(f"[{service}] {line}")
