"""``fairlead robot ls``: every robot, its parts and what they take."""

from __future__ import annotations

from typing import Any

from fairlead.errors import ConfigError
from fairlead.paths import robot_ids
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.deployment_choice import JsonOption

EXAMPLE = "fairlead robot ls"


def command(as_json: JsonOption = False) -> None:
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
