"""``fairlead layout``: the state vectors that policies get."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any

import typer

from fairlead.errors import ConfigError
from fairlead.layout import load_layout
from fairlead.plugins import LAYOUTS
from fairlead.skill.manifest import load_skill
from fairlead.skill.state_contract import StateContract
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.options import JsonOption, example, make_group
from fairlead_tools.parity.layout_comparison import FieldReport, verify_layout


@example("fairlead layout ls")
def ls_command(as_json: JsonOption = False) -> None:
    """List state layouts: width, bindings that must be given, content, and whose they are."""
    rows: list[dict[str, Any]] = []
    wrong: dict[str, str] = {}
    for name in LAYOUTS.names():
        try:
            layout, package = load_layout(name), LAYOUTS.find(name).package
        except ConfigError as error:
            wrong[name] = str(error)
            continue
        rows.append({"layout": name, "dim": layout.dim, "required_bindings": list(layout.required),
                     "content": layout.content, "package": package})  # fmt: skip
    if as_json:
        print_json([*rows, *({"layout": name, "error": text} for name, text in wrong.items())])
        return
    lines = [
        (row["layout"], row["dim"] or "-", row["content"], ", ".join(row["required_bindings"]),
         row["package"])
        for row in rows
    ]  # fmt: skip
    print_table(("LAYOUT", "DIM", "CONTENT", "BINDINGS NEEDED", "FROM"), lines)
    for text in wrong.values():
        echo(text, err=True)


@example("fairlead layout verify oracle-counter-to-cabinet")
def verify_command(
    skill: Annotated[str | None, typer.Argument(help="folder under rskills/")] = None,
    layout: Annotated[
        str | None, typer.Option(help="instead of a skill: a layout with its example bindings")
    ] = None,
    ticks: Annotated[int, typer.Option(min=1, help="control periods to drive at random")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="scene and commands")] = 0,
    robot: Annotated[
        str | None,
        typer.Option(help="folder under robots/; default: the skill's first, or panda_mobile"),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Drive the simulator at random and compare every field of a layout with truth."""
    what, contract, default_robot = _subject(skill, layout)
    reports = verify_layout(contract, robot or default_robot, n_ticks=ticks, seed=seed)
    good = all(report.ok for report in reports)
    if as_json:
        fields = [dataclasses.asdict(report) | {"ok": report.ok} for report in reports]
        print_json(
            {what: skill or layout, "ticks": ticks, "seed": seed, "ok": good} | {"fields": fields}
        )
    else:
        header = ("FIELD", "WORST", "ALLOWED", "UNIT", "AT TICK", "")
        print_table(header, [_row(report) for report in reports])
        if skill is not None and not good:
            echo(f"fix state_contract.bindings in rskills/{skill}/rskill.yaml")
    if not good:
        raise typer.Exit(1)


def _subject(skill: str | None, layout: str | None) -> tuple[str, StateContract, str]:
    """What is verified: a word for it, its contract, and the robot if none is named."""
    if (skill is None) == (layout is None):
        raise ConfigError("layout verify: expected a skill or --layout, got both or neither")
    if skill is not None:
        manifest = load_skill(skill)
        return "skill", manifest.state_contract, manifest.embodiments[0]
    assert layout is not None
    found = load_layout(layout, "layout verify")
    if found.dim is None:
        raise ConfigError(f"layout verify: layout {layout} has no assembler")
    contract = StateContract(layout=layout, dim=found.dim, bindings=found.example)
    return "layout", contract, "panda_mobile"


def _row(report: FieldReport) -> tuple[object, ...]:
    worst, allowed = f"{report.worst:.2e}", f"{report.allowed:.0e}"
    verdict = "ok" if report.ok else f"FAILED: {report.binding}"
    if report.ok and report.other_sign_ticks:
        verdict = f"ok; quaternion of the other sign in {report.other_sign_ticks} tick(s)"
    return (report.field, worst, allowed, report.unit, report.at_tick, verdict)


group = make_group(
    "layout",
    "List state layouts and verify them against simulator truth.",
    {"ls": ls_command, "verify": verify_command},
)
