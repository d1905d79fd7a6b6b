"""``fairlead demo``, ``parity`` and ``plot``: a run, compared, drawn."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError, FairleadError, ServiceError
from fairlead.operate.goal_run import GoalOptions
from fairlead.paths import deployment_path
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_tools.cli.console import ProgressLine, echo, print_json, print_table
from fairlead_tools.cli.options import (
    MAX_NUMBER,
    JsonOption,
    RunningOption,
    example,
    parse_deployment,
)
from fairlead_tools.cli.why import choose_decision_log
from fairlead_tools.demo.demo_run import DemoWish, check_wish, run_demo
from fairlead_tools.parity.comparison import Comparison, compare
from fairlead_tools.parity.deployed_episode import DeployedEpisode, deployed_episodes
from fairlead_tools.parity.local_episode import local_episode
from fairlead_tools.parity.plain_episodes import (
    PlainComparison,
    check_comparable,
    compare_with_plain,
)
from fairlead_tools.parity.random_episodes import random_episodes
from fairlead_tools.record.run_log import Run, newest_log, read_run
from fairlead_tools.record.timeline import draw_timeline

SOURCE = "panda_mobile_sim"
CopiedOption = Annotated[
    Path | None,
    typer.Option(
        "--deployment", "-d", parser=parse_deployment, metavar="NAME_OR_FILE",
        help="what to copy; default: panda_mobile_sim",
    ),
]  # fmt: skip


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
    camera: Annotated[str, typer.Option(help="the simulator's that films")] = DemoWish.camera,
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Run a skill through its own four services, challenge the gate, write video and timeline."""
    source = deployment or deployment_path(SOURCE)
    wish = DemoWish(source, out, skill, seed, realtime, not no_video, gif, camera)
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
    first, last = ticks or (first - around, last + around)
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


DEADLINE_TICKS = 800


@example("fairlead parity --seed 3")
def parity_command(
    seed: Annotated[int, typer.Option(min=0, max=MAX_NUMBER, help="of the first episode")] = 0,
    skill: Annotated[str, typer.Option(help="folder under rskills/")] = "oracle-counter-to-cabinet",
    deployment: CopiedOption = None,
    ticks: Annotated[int, typer.Option(min=1, help="longest episode")] = DEADLINE_TICKS,
    episodes: Annotated[int, typer.Option(min=1, max=1000, help="of as many seeds")] = 1,
    random_scale: Annotated[
        float | None,
        typer.Option(
            "--random", min=0.0, max=1.0,
            help="random vectors of this scale, through all but the gate; 1: full scale",
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option(file_okay=False, help="folder for traces and logs, made anew")
    ] = Path("out/parity"),
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Run episodes through the services and again in plain robosuite; compare every bit.

    Plain robosuite is a loop of env.step with the policy's raw vectors, in a process that knows
    nothing of the HAL. Compared are the vectors given to env.step and the simulator's qpos and
    qvel, up to the first tick held inside an episode: training knows no holds. Observations and
    actions are computed again in one process. Ports and state folder are its own; a running robot
    is not disturbed. Random vectors go through dispatch and the HAL in one process: the gate would
    refuse most of them.
    """
    source = deployment or deployment_path(SOURCE)
    loaded, manifest = load_deployment(source), load_skill(skill)
    check_comparable(loaded, manifest)
    wish = GoalOptions(manifest.id, deadline_ticks=ticks)
    seeds = range(seed, seed + episodes)
    if random_scale is not None:
        deployed = random_episodes(loaded, manifest, random_scale, seeds, ticks)
    else:
        with ProgressLine(quiet=as_json) as line:
            deployed = deployed_episodes(
                source, wish, seeds, out / "state", lambda now: line.show(now.line())
            )
    plain = compare_with_plain(loaded, manifest, deployed)
    again = [] if random_scale is not None else _again(loaded, manifest, deployed)
    same = all(one.same for one in plain) and all(row.same for row in again)
    same = same and any(one.compared for one in plain)  # nothing compared proves nothing
    if as_json:
        print_json({"same": same, "policy": _rows(again), "episodes": _documents(plain, deployed)})
    else:
        _print(again, plain, same)
    if not same:
        raise typer.Exit(1)


def _again(
    deployment: Deployment, skill: SkillManifest, deployed: list[DeployedEpisode]
) -> list[Comparison]:
    """What the policy saw and said, computed in one process where no tick was held."""
    found = []
    for one in deployed:
        if not any(one.trace.held[one.reset.held_ticks :]):
            steps = len(one.trace.packed)
            local = local_episode(deployment, skill, one.seed, one.reset, steps)
            found += compare(one.trace, local, ("observations", "actions"))
    return found


def _rows(rows: list[Comparison]) -> list[dict[str, object]]:
    return [dataclasses.asdict(row) | {"same": row.same} for row in rows]


def _documents(
    plain: list[PlainComparison], deployed: list[DeployedEpisode]
) -> list[dict[str, object]]:
    return [
        dataclasses.asdict(one)
        | {"rows": _rows(one.rows), "same": one.same, "succeeded": other.trace.succeeded}
        for one, other in zip(plain, deployed, strict=True)
    ]


def _print(again: list[Comparison], plain: list[PlainComparison], same: bool) -> None:
    header = ("SEED", "QUANTITY", "DEPLOYED", "BESIDE IT", "")
    table = [
        (
            str(one.seed),
            _NAMES[row.quantity],
            row.deployed,
            row.local,
            row.difference or "identical",
        )
        for one in plain
        for row in one.rows
    ]
    table += [
        ("", _NAMES[row.quantity], row.deployed, row.local, row.difference or "identical")
        for row in again
    ]
    print_table(header, table)
    for one in plain:
        held = f"{one.held} ticks held inside the episode"
        if one.held:
            held += f", after which qpos is up to {one.apart:.3g} from plain robosuite's"
        echo(f"seed {one.seed}: {one.compared} of {one.ticks} rows compared; {held}")
    verdict = "identical, bit for bit" if same else "DIFFERENT"
    if not any(one.compared for one in plain):
        verdict = "NOTHING COMPARED: every tick was held"
    echo(f"plain robosuite and {len(plain)} episode(s): {verdict}")


_NAMES = {
    "packed": "vectors to env.step",
    "qpos": "qpos",
    "qvel": "qvel",
    "observations": "observations, in one process",
    "actions": "actions, in one process",
}
