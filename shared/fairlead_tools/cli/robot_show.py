"""``fairlead robot show``: the limits the gate really enforces, in SI."""

from __future__ import annotations

import json
from typing import Annotated, Any

import typer

from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.deployment_choice import JsonOption
from fairlead_tools.cli.robot_choice import RobotArgument
from fairlead_tools.limits.effective_limits import effective_limits

EXAMPLE = "fairlead robot show panda_mobile"


def command(
    robot: RobotArgument,
    profile: Annotated[str, typer.Option(help="safety profile")] = "sim",
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
    limits = (joint[f"{name}_limit"] for name in ("velocity", "acceleration", "effort"))
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
    return "/".join(str(one) for one in value) if isinstance(value, list) else str(value)
