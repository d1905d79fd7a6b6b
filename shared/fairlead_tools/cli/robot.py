"""``fairlead robot``: look at robots and compile their gate files."""

from __future__ import annotations

import json
from itertools import chain, repeat
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir, robot_ids
from fairlead.robot.capsules import load_capsules
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.options import JsonOption, RobotArgument, example, make_group
from fairlead_tools.cli.robot_capsules import capsules_command, distances_command
from fairlead_tools.cli.robot_new import check_command, measure_command, new_command
from fairlead_tools.limits.bounds import Bound, robot_bounds
from fairlead_tools.limits.effective_limits import effective_limits

if TYPE_CHECKING:
    from fairlead_tools.shape.robot_model import RobotModel

ProfileOption = Annotated[str, typer.Option(help="safety profile")]


@example("fairlead robot ls")
def ls_command(as_json: JsonOption = False) -> None:
    """Show every robot that ships or is the user's own: rate, joints, parts and their modes."""
    rows: list[dict[str, Any]] = []
    wrong: dict[str, str] = {}
    for name in robot_ids():
        try:
            robot = load_robot(name)
        except ConfigError as error:
            wrong[name] = str(error)
            continue
        parts = {part.name: list(part.modes) for part in robot.parts}
        rows.append({"robot": name, "hz": 1e9 / robot.tick_period_ns,
                     "joints": robot.n_dof, "parts": parts})  # fmt: skip
    if as_json:
        print_json([*rows, *({"robot": name, "error": text} for name, text in wrong.items())])
        return
    lines = [(r["robot"], f"{r['hz']:g}", str(r["joints"]), ", ".join(r["parts"])) for r in rows]
    print_table(("ROBOT", "HZ", "JOINTS", "PARTS"), lines)
    for text in wrong.values():
        echo(text, err=True)


@example("fairlead robot show panda_mobile")
def show_command(
    robot: RobotArgument,
    profile: ProfileOption = "sim",
    sources: Annotated[
        bool, typer.Option("--sources", help="every limit on a line, with unit and source")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Show a robot's effective limits: what is compiled into the gate's file, in SI units."""
    manifest = load_robot(robot)
    config: dict[str, Any] = json.loads(compile_gate_config(manifest, profile))
    if as_json:
        print_json(config)
        return
    if sources:
        rows = effective_limits(manifest, profile)
        header = ("WHERE", "LIMIT", "VALUE", "UNIT", "SOURCE")
        print_table(header, [(r.where, r.name, r.value, r.unit, r.source) for r in rows])
        return
    echo(
        f"{robot}, profile {profile}: {1e9 / config['period_ns']:g} Hz, lockstep "
        f"{'allowed' if config['lockstep_allowed'] else 'not allowed'}, "
        f"robot hash {config['robot_hash'][:16]}\n"
    )
    print_table(
        ("JOINT", "PART", "KIND", "LOWER", "UPPER", "VELOCITY", "ACCELERATION", "EFFORT"),
        [_joint_row(joint) for joint in config["joints"]],
    )
    echo("lengths in m, angles in rad, per second; effort in N m or N\n")
    print_table(("PART", "MODE", "LIMITS"), _mode_rows(config["parts"]))


def _joint_row(joint: dict[str, Any]) -> tuple[object, ...]:
    bounds = joint.get("bounds")
    free = "zones" if "zones" in joint else "none"
    lower, upper = (bounds["lower"], bounds["upper"]) if isinstance(bounds, dict) else (free, "")
    limits = (_text(joint[f"{name}_limit"]) for name in ("velocity", "acceleration", "effort"))
    return (joint["name"], joint["part"], joint["kind"], lower, upper, *limits)


def _mode_rows(parts: list[dict[str, Any]]) -> list[tuple[str, str, str]]:
    return [
        (
            part["name"],
            mode,
            ", ".join(f"{k} {_text(v)}" for k, v in limits.items() if k != "source"),
        )
        for part in parts
        for mode, limits in part["modes"].items()
    ]


def _text(value: object) -> str:
    if value is None:
        return "none"
    return "/".join(str(one) for one in value) if isinstance(value, list) else str(value)


NOTHING = "NOT ENFORCED"


@example("fairlead robot bounds panda_mobile")
def bounds_command(
    robot: RobotArgument,
    profile: ProfileOption = "sim",
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


@example("fairlead robot compile panda_mobile")
def compile_command(
    robot: RobotArgument,
    check: Annotated[
        bool, typer.Option("--check", help="write nothing; exit 1 if a file is not current")
    ] = False,
) -> None:
    """Compile robot.yaml into gate.PROFILE.json, one file for each safety profile.

    Where robot.yaml names a simulator's model, or ROBOT.xml lies beside it, its frames are
    compared with the description's first, and its geometry with the capsules.
    """
    manifest = load_robot(robot)
    from fairlead_tools.shape.robot_model import robot_model  # takes long: not for a misspelt name

    model = robot_model(manifest, None, "robot compile")
    nothing = f"robot.yaml names none (simulator.model), and {robot}.xml is not there"
    alone = f"{manifest.description} is compared with no model: {nothing}"
    echo(alone if model is None else model.check())
    _warn_of_uncovered(manifest, model)
    stale = []
    for profile in manifest.safety:
        path = robot_dir(robot) / f"gate.{profile}.json"
        text = compile_gate_config(manifest, profile)
        if still_open := manifest.open_numbers(profile):
            echo(f"{path} is not made: {still_open}", err=True)
        elif path.is_file() and path.read_bytes() == text.encode():
            echo(f"{path} is current")
        elif check:
            stale.append(path)
        else:
            _write(path, text)
    for path in stale:
        echo(f"ERROR {path} is not current; fix: fairlead robot compile {robot}", err=True)
    if stale:
        raise typer.Exit(1)


def _warn_of_uncovered(manifest: RobotManifest, model: RobotModel | None) -> None:
    """The gate sees nothing of a robot but its capsules."""
    from fairlead_tools.shape.geometry import geometry_source, model_geometry
    from fairlead_tools.shape.robot_shape import RobotShape

    try:
        source = geometry_source(manifest, None) if model is None else model_geometry(model)
        shape = RobotShape(manifest, source, lambda _: None)
    except ConfigError:
        return  # nothing here has its geometry
    for problem in shape.uncovered(load_capsules(manifest).capsules):
        echo(f"WARNING {manifest.id}: {problem}", err=True)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"robot compile: cannot write {path}: {error.strerror}") from None
    echo(f"wrote {path}")


group = make_group(
    "robot",
    "Draft, check, list and show robots; fit their capsules, compile their gate files.",
    {
        "new": new_command,
        "check": check_command,
        "ls": ls_command,
        "show": show_command,
        "bounds": bounds_command,
        "capsules": capsules_command,
        "compile": compile_command,
        "distances": distances_command,
        "measure": measure_command,
    },
)
