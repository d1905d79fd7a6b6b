"""``fairlead parity``: the deployed numbers equal the training loop's, bit for bit."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated

import typer

from fairlead.cli.console import print_json, print_table
from fairlead.cli.deployment_choice import JsonOption, parse_deployment
from fairlead.cli.progress_line import ProgressLine
from fairlead.cli.wire_number import MAX_NUMBER
from fairlead.deploy.deployment import load_deployment
from fairlead.operate.goal_run import GoalWish
from fairlead.parity.comparison import Comparison, compare
from fairlead.parity.deployed_episode import deployed_episode
from fairlead.parity.local_episode import local_episode
from fairlead.paths import deployment_path
from fairlead.skill.manifest import load_skill

EXAMPLE = "fairlead parity --seed 3"
SOURCE = "panda_mobile_sim"
DEADLINE_TICKS = 800


def command(
    seed: Annotated[int, typer.Option(min=0, max=MAX_NUMBER, help="of the episode")] = 0,
    skill: Annotated[str, typer.Option(help="folder under rskills/")] = "oracle-counter-to-cabinet",
    deployment: Annotated[
        Path | None,
        typer.Option(
            "--deployment", "-d", parser=parse_deployment, metavar="NAME_OR_FILE",
            help="what to copy; default: panda_mobile_sim",
        ),
    ] = None,
    ticks: Annotated[int, typer.Option(min=1, help="longest episode")] = DEADLINE_TICKS,
    out: Annotated[
        Path, typer.Option(file_okay=False, help="folder for traces and logs, made anew")
    ] = Path("out/parity"),
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Run one episode through the services and again in one process; compare every bit.

    Compared: observations, raw actions, vectors given to the simulator, its qpos and
    qvel. Uses ports and a state folder of its own; a running robot is not disturbed.
    """
    source = deployment or deployment_path(SOURCE)
    manifest = load_skill(skill)
    wish = GoalWish(skill, deadline_ticks=ticks)
    with ProgressLine(quiet=as_json) as line:
        deployed, reset = deployed_episode(
            source, wish, seed, out / "state", lambda now: line.show(now.line())
        )
    local = local_episode(load_deployment(source), manifest, seed, reset, len(deployed.packed))
    rows = compare(deployed, local)
    same = all(row.same for row in rows) and deployed.succeeded == local.succeeded
    if as_json:
        table = [dataclasses.asdict(row) | {"same": row.same} for row in rows]
        print_json({"seed": seed, "same": same, "succeeded": deployed.succeeded, "rows": table})
    else:
        _print(rows, seed, same, deployed.succeeded, reset.held_ticks)
    if not same:
        raise typer.Exit(1)


def _print(rows: list[Comparison], seed: int, same: bool, succeeded: bool, held_ticks: int) -> None:
    header = ("QUANTITY", "DEPLOYED", "IN ONE PROCESS", "")
    table = [(r.quantity, r.deployed, r.local, r.difference or "identical") for r in rows]
    print_table(header, table)
    verdict = "identical, bit for bit" if same else "DIFFERENT"
    task = "done" if succeeded else "not done"
    typer.echo(f"seed {seed}: {verdict}; task {task}; {held_ticks} held ticks after the reset")
