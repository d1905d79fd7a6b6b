"""``fairlead layout verify``: a skill's state vector against simulator truth."""

from __future__ import annotations

import dataclasses
from typing import Annotated

import typer

from fairlead.cli.console import print_json, print_table
from fairlead.cli.deployment_choice import JsonOption
from fairlead.cli.verify_layout import FieldReport, verify_layout
from fairlead.skill import load_skill

EXAMPLE = "fairlead layout verify oracle-counter-to-cabinet"


def command(
    skill: Annotated[str, typer.Argument(help="folder under rskills/")],
    ticks: Annotated[int, typer.Option(min=1, help="control periods to drive at random")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="scene and commands")] = 0,
    robot: Annotated[
        str | None, typer.Option(help="folder under robots/; default: the skill's first")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Drive the simulator at random and compare every field of the skill's layout with truth."""
    reports = verify_layout(load_skill(skill), n_ticks=ticks, seed=seed, robot_id=robot)
    good = all(report.ok for report in reports)
    if as_json:
        fields = [dataclasses.asdict(report) | {"ok": report.ok} for report in reports]
        print_json({"skill": skill, "ticks": ticks, "seed": seed, "ok": good, "fields": fields})
    else:
        header = ("FIELD", "WORST", "ALLOWED", "UNIT", "AT TICK", "")
        print_table(header, [_row(report) for report in reports])
        if not good:
            typer.echo(f"fix state_contract.bindings in rskills/{skill}/rskill.yaml")
    if not good:
        raise typer.Exit(1)


def _row(report: FieldReport) -> tuple[object, ...]:
    worst, allowed = f"{report.worst:.2e}", f"{report.allowed:.0e}"
    verdict = "ok" if report.ok else f"FAILED: {report.binding}"
    return (report.field, worst, allowed, report.unit, report.at_tick, verdict)
