"""``fairlead logs``: what the services printed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fairlead.cli.console import echo, print_json
from fairlead.cli.deployment_choice import JsonOption, RunningOption, choose_running
from fairlead.errors import ConfigError

EXAMPLE = "fairlead logs hal -n 50"


def command(
    service: Annotated[str | None, typer.Argument(help="one service; all without it")] = None,
    deployment: RunningOption = None,
    lines: Annotated[int, typer.Option("-n", "--lines", min=1, help="newest lines of each")] = 20,
    state_dir: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help="state folder of a run that has ended"),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Print the newest log lines of a deployment's services."""
    entry = choose_running(deployment) if state_dir is None else None
    folder = (state_dir or Path(entry.state_dir if entry else "")) / "logs"
    files = {path.stem: path for path in sorted(folder.glob("*.log"))}
    by_hand = entry.by_hand if entry is not None else {}
    if service in by_hand or (by_hand and not files):
        raise ConfigError(
            f"logs: {service or ', '.join(by_hand)}: started by hand, so it prints in the "
            "terminal (or unit) that started it; only `fairlead up` keeps logs"
        )
    if not files:
        raise ConfigError(f"logs: no *.log in {folder}; is that a state folder of `fairlead up`?")
    if service is not None and service not in files:
        raise ConfigError(f"logs: no service {service!r} (valid: {', '.join(files)})")
    wanted = [service] if service is not None else list(files)
    newest = {one: newest_lines(files[one], lines) for one in wanted}
    if as_json:
        print_json(newest)
        return
    for one, texts in newest.items():
        for text in texts:
            echo(f"[{one}] {text}")


def newest_lines(path: Path, count: int) -> list[str]:
    """The last ``count`` lines of a log file."""
    text = path.read_bytes().decode(errors="replace")
    return text.removesuffix("\n").split("\n")[-count:]
