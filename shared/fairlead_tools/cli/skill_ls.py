"""``fairlead skill ls``: every skill, admitted or dropped, and why."""

from __future__ import annotations

from fairlead.errors import ConfigError
from fairlead.plugins import POLICIES
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import load_skill, skill_ids
from fairlead_tools.cli.console import print_json, print_table
from fairlead_tools.cli.deployment_choice import JsonOption
from fairlead_tools.cli.robot_choice import RobotOption

EXAMPLE = "fairlead skill ls --robot panda_mobile"


def command(
    robot: RobotOption = "panda_mobile",
    as_json: JsonOption = False,
) -> None:
    """Show every skill, shipped or installed: admitted on this robot, or dropped and why."""
    manifest = load_robot(robot)
    problems = {name: skill_problems(name, manifest) for name in skill_ids()}
    if as_json:
        print_json(
            [{"skill": n, "admitted": not found, "reasons": found} for n, found in problems.items()]
        )
        return
    rows = [
        (n, "dropped" if found else "admitted", _why(n, robot, found))
        for n, found in problems.items()
    ]
    print_table(("SKILL", f"ON {robot}", "WHY"), rows)


def _why(skill: str, robot: str, reasons: list[str]) -> str:
    """The first reason, and where the others are said."""
    lines = [line for reason in reasons for line in reason.splitlines()]
    more = f"  (all {len(lines)}: fairlead skill check {skill} --robot {robot})"
    return "".join(lines[:1]) + (more if len(lines) > 1 else "")


def skill_problems(name: str, robot: RobotManifest) -> list[str]:
    """Every reason against running one skill on a robot; a broken manifest is one."""
    try:
        skill = load_skill(name)
        problems = admission_problems(skill, robot)
        POLICIES.find(skill.policy.backend, "policy.backend")
    except ConfigError as error:
        return [str(error)]
    return problems
