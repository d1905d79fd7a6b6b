"""``fairlead robot bounds``: each declared limit, the check behind it, the test behind that."""

from __future__ import annotations

from itertools import chain, repeat
from pathlib import Path
from typing import Annotated, Any

import typer

from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.deployment_choice import JsonOption
from fairlead_tools.cli.robot_choice import RobotArgument
from fairlead_tools.limits.bounds import Bound, robot_bounds

EXAMPLE = "fairlead robot bounds panda_mobile"
NOTHING = "NOT ENFORCED"


def command(
    robot: RobotArgument,
    profile: Annotated[str, typer.Option(help="safety profile")] = "sim",
    strict: Annotated[
        bool, typer.Option("--strict", help="exit 1 if a limit is not enforced")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """List every declared limit: its value, the check and process behind it, its test."""
    bounds = robot_bounds(load_robot(robot), profile)
    missing = sum(not bound.enforced_by for bound in bounds)
    if as_json:
        print_json([_document(bound) for bound in bounds])
    else:
        header = ("WHERE", "LIMIT", "VALUE", "UNIT", "CHECK", "PROCESS", "TEST")
        print_table(header, [row for bound in bounds for row in _rows(bound)])
        echo(
            f"\n{robot}, profile {profile}: {len(bounds)} declared limits, "
            f"{len(bounds) - missing} enforced, {missing} {NOTHING} in this release"
        )
    if strict and missing:
        raise typer.Exit(1)


def _rows(bound: Bound) -> list[tuple[str, ...]]:
    limit = bound.limit
    declared = (limit.where, limit.name, _value(bound), limit.unit)
    if not bound.enforced_by:
        return [(*declared, NOTHING, "-", "-")]
    return [
        (*(declared if first else ("", "", "", "")), by.check, by.process, _test(by.file, by.test))
        for first, by in zip(chain((True,), repeat(False)), bound.enforced_by, strict=False)
    ]


def _test(file: str, name: str) -> str:
    return f"{Path(file).name}: {name}"


def _value(bound: Bound) -> str:
    value = bound.limit.value
    if isinstance(value, str):
        return value
    if isinstance(value, tuple):
        return "/".join(f"{one:g}" for one in value) or "declared"
    return f"{value:g}"


def _document(bound: Bound) -> dict[str, Any]:
    return {
        "where": bound.limit.where,
        "limit": bound.limit.name,
        "value": bound.limit.value,
        "unit": bound.limit.unit,
        "source": bound.limit.source,
        "enforced_by": [
            {"check": by.check, "process": by.process, "file": by.file, "test": by.test}
            for by in bound.enforced_by
        ],
    }
