"""``fairlead demo`` and ``plot``: a run, drawn."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from fairlead.errors import ConfigError, FairleadError, ServiceError
from fairlead.paths import deployment_path
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.cli.console import ProgressLine, echo, ends_like_ctrl_c, print_json
from fairlead_tools.cli.options import (
    MAX_NUMBER,
    JsonOption,
    RunningOption,
    deployment_option,
    example,
)
from fairlead_tools.cli.why import choose_decision_log
from fairlead_tools.demo.demo_run import DemoOptions, check_demo, run_demo
from fairlead_tools.record.run_log import Run, newest_log, read_run
from fairlead_tools.record.timeline import draw_timeline

SOURCE = "panda_mobile_sim"
CopiedOption = Annotated[
    Path | None,
    deployment_option("--deployment", "-d", what="what to copy: ", without=SOURCE),
]


@example("fairlead demo --realtime")
def demo_command(
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
    deployment: CopiedOption = None,
    camera: Annotated[str, typer.Option(help="the simulator's that films")] = DemoOptions.camera,
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Run a skill through its own four services, challenge the gate, write video and timeline."""
    source = deployment or deployment_path(SOURCE)
    wish = DemoOptions(source, out, skill, seed, realtime, not no_video, gif, camera)
    check_demo(wish)
    try:
        with ends_like_ctrl_c(), ProgressLine(quiet=as_json) as line:
            result = run_demo(
                wish,
                lambda text: None if as_json else line.say(text),
                lambda now: line.show(now.line()),
            )
    except FairleadError as error:
        raise ServiceError(
            f"{error}\n  logs: fairlead logs --state-dir {shlex.quote(str(out / 'state'))}\n"
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


AROUND_S = 1.0
MOST_TICKS = 20_000


def parse_ticks(text: str) -> tuple[int, int]:
    """``FIRST:LAST``."""
    first, colon, last = text.partition(":")
    if not (colon and first.isdecimal() and last.isdecimal() and int(first) <= int(last)):
        raise typer.BadParameter(f"--ticks: expected FIRST:LAST such as 70:150, got {text!r}")
    return int(first), int(last)


@example("fairlead plot out/demo/state --ticks 70:150")
def plot_command(
    run: Annotated[
        Path | None,
        typer.Argument(
            exists=True,
            help="a decision log, or a folder of them, or a state folder: its newest; "
            "without it: of what runs here, or ran last",
        ),
    ] = None,
    deployment: RunningOption = None,
    ticks: Annotated[
        str | None,
        typer.Option(
            metavar="FIRST:LAST",
            help="of the newest claim's session; default: that claim, and a second around it",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(dir_okay=False, help="the picture")] = Path("timeline.png"),
) -> None:
    """Draw what the robot was asked, what the gate released and what the robot did of it.

    A panel for each commanded quantity, in one unit and one frame; held ticks, refused chunks
    and stops are marked.
    """
    asked = parse_ticks(ticks) if ticks is not None else None
    log = choose_decision_log(deployment, None) if run is None else run
    whole = read_run(newest_log(log) if log.is_dir() else log)
    robot = load_robot(whole.header.robot)
    _check_same(whole, robot, log)
    shown = _cut(whole, robot, asked, log)
    draw_timeline(shown, robot, _title(shown), out)
    if whole.damage:
        echo(f"the log is {whole.damage}", err=True)
    echo(f"{out}: ticks {shown.joints[0].tick} to {shown.tick} of {log}")


def _check_same(run: Run, robot: RobotManifest, log: Path) -> None:
    if run.joints and run.joints[-1].robot_hash != robot.robot_hash:
        raise ConfigError(
            f"plot: {log} is of another robot.yaml or description than robots/{robot.id} has now: "
            "its rows would be misread; draw it with the files it was recorded with"
        )


def _cut(run: Run, robot: RobotManifest, ticks: tuple[int, int] | None, log: Path) -> Run:
    claim = run.newest_claim
    if claim is None:
        raise ConfigError(f"plot: {log}: no chunk in it: nothing was asked of the robot")
    session, first, last = claim
    around = round(AROUND_S * 1e9 / robot.tick_period_ns)
    first, last = ticks or (max(first - around, 0), last + around)
    if last - first > MOST_TICKS:
        raise ConfigError(
            f"plot: {last - first} ticks are too many for a picture (at most {MOST_TICKS}); "
            f"choose some: --ticks {first}:{first + MOST_TICKS}"
        )
    shown = run.between(first, last, session)
    if not shown.joints or not shown.chunks:
        raise ConfigError(
            f"plot: {log}: nothing was asked from tick {first} to {last}; the newest claim's "
            f"chunks are for ticks {claim[1]} to {claim[2]}"
        )
    return shown


def _title(run: Run) -> str:
    moved = {one.claim_id for _, one in run.verdicts if one.released_first}
    claims = [claim for claim_id, claim in run.claims.items() if claim_id in moved]
    skills = dict.fromkeys(f"{one.skill} ({one.source})" for one in claims)
    who = ", ".join(skills) or "nothing released"
    return f"{who} on {run.header.robot}, profile {run.header.profile}, {run.header.started}"
