"""Every command of ``fairlead``: one file each, put together here."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead_tools.cli import (
    arm,
    cancel,
    demo,
    disarm,
    down,
    episode,
    evaluate,
    judge,
    layout,
    logs,
    parity,
    plot,
    ps,
    reset,
    restart,
    robot,
    router,
    run,
    service,
    skill,
    status,
    stop,
    topic,
    up,
    why,
)
from fairlead_tools.cli.group import EXIT_CODES, add_commands
from fairlead_tools.cli.version import print_version

app = typer.Typer(
    name="fairlead",
    help="Run learned robot policies through typed commands and a C++ safety gate.",
    epilog=EXIT_CODES,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


@app.callback()
def _options(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=print_version,
            is_eager=True,
            help="Show which fairlead, gate and data this is, and exit.",
        ),
    ] = False,
) -> None:
    """Options of ``fairlead`` itself; the text of its help stands above."""


add_commands(
    app,
    {
        "up": up,
        "down": down,
        "service": service,
        "restart": restart,
        "ps": ps,
        "logs": logs,
        "run": run,
        "cancel": cancel,
        "episode": episode,
        "eval": evaluate,
        "arm": arm,
        "disarm": disarm,
        "stop": stop,
        "reset": reset,
        "status": status,
        "why": why,
        "judge": judge,
        "plot": plot,
        "parity": parity,
        "demo": demo,
        "router": router,
    },
)
for _group in (skill.group, robot.group, layout.group, topic.group):
    app.add_typer(_group)
