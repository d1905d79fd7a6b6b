"""``fairlead demo``: the robot does its task, and what it did is drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fairlead.errors import FairleadError, ServiceError
from fairlead.paths import deployment_path
from fairlead_tools.cli.console import echo, print_json
from fairlead_tools.cli.deployment_choice import JsonOption
from fairlead_tools.cli.progress_line import ProgressLine
from fairlead_tools.cli.wire_number import MAX_NUMBER
from fairlead_tools.demo.demo_run import DemoWish, check_wish, run_demo

EXAMPLE = "fairlead demo --realtime"
SOURCE = "panda_mobile_sim"


def command(
    out: Annotated[Path, typer.Option(file_okay=False, help="folder for the results")] = Path(
        "out/demo"
    ),
    seed: Annotated[int, typer.Option(min=0, max=MAX_NUMBER, help="of the episode")] = 0,
    skill: Annotated[str, typer.Option(help="folder under rskills/")] = "oracle-counter-to-cabinet",
    realtime: Annotated[
        bool, typer.Option("--realtime", help="at the robot's own rate instead of lockstep")
    ] = False,
    no_video: Annotated[bool, typer.Option("--no-video", help="without a camera")] = False,
    gif: Annotated[bool, typer.Option("--gif", help="the video also as demo.gif")] = False,
    as_json: JsonOption = False,
) -> None:
    """Run a skill through its own four services, challenge the gate, write video and timeline."""
    wish = DemoWish(deployment_path(SOURCE), out, skill, seed, realtime, not no_video, gif)
    check_wish(wish)
    try:
        with ProgressLine(quiet=as_json) as line:
            result = run_demo(
                wish,
                lambda text: None if as_json else line.say(text),
                lambda now: line.show(now.line()),
            )
    except FairleadError as error:
        raise ServiceError(
            f"{error}\n  logs: fairlead logs --state-dir {out / 'state'}\n"
            "  then try again: fairlead demo"
        ) from None
    if as_json:
        print_json(result.summary)
    else:
        ticks, seconds = result.summary["ticks"], result.summary["seconds"]
        echo(f"{result.goal.outcome}: {ticks} ticks in {seconds} s")
        for path in result.written:
            echo(f"  {path}")
        if "video" in result.summary:
            echo(f"  no video: {result.summary['video']}")
    if result.goal.outcome != "succeeded":
        raise ServiceError(
            f"demo: the goal {result.goal.outcome} ({result.goal.detail}); see {out}/summary.json"
        )
