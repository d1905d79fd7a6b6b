"""``fairlead skill check``: may this skill run on this robot?"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.messages import HalStatus
from fairlead.operate.client import RobotClient
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems, worth_saying
from fairlead.skill.manifest import SkillManifest, find_skill, read_skill
from fairlead_tools.cli.console import echo, print_json
from fairlead_tools.cli.deployment_choice import JsonOption, parse_deployment
from fairlead_tools.cli.policy_problems import policy_problems
from fairlead_tools.cli.skill_choice import SkillArgument
from fairlead_tools.skills.checkpoint_stats import read_checkpoint_stats
from fairlead_tools.skills.contract_findings import contract_findings, named_outputs

EXAMPLE = "fairlead skill check oracle-counter-to-cabinet --robot panda_mobile"


def command(
    skill: SkillArgument,
    robot: Annotated[
        str, typer.Option(help="folder under robots/; default: the first the skill was made for")
    ] = "",
    deployment: Annotated[
        Path | None,
        typer.Option(
            "--deployment",
            "-d",
            parser=parse_deployment,
            metavar="NAME_OR_FILE",
            help="also compare with the robot that runs here: ranges, part order, cameras",
        ),
    ] = None,
    stats: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            dir_okay=False,
            help="the checkpoint's normaliser statistics (LeRobot, openpi or RLDX JSON): also "
            "report dimensions that are constant but routed, or active but discarded",
        ),
    ] = None,
    embodiment: Annotated[
        str, typer.Option(help="with --stats of RLDX: whose, if the file has several")
    ] = "",
    as_json: JsonOption = False,
) -> None:
    """Check a skill's manifest and whether the robot admits it; exit 1 with every reason if not."""
    folder = find_skill(skill)
    manifest = read_skill(folder)
    robot = robot or manifest.embodiments[0]
    loaded = load_robot(robot)
    problems = admission_problems(manifest, loaded, _running(deployment))
    told = worth_saying(problems, manifest, loaded)
    wrong = policy_problems(manifest)
    problems, told = problems + wrong, told + wrong
    report: dict[str, Any] = {
        "skill": skill, "robot": robot, "admitted": not problems, "reasons": problems,
    }  # fmt: skip
    found = None if stats is None else _compare(manifest, stats, embodiment)
    if found is not None:
        report["statistics"] = found
    if as_json:
        print_json(report)
    else:
        _print(skill, robot, told, folder)
        if found is not None:
            _print_findings(skill, found)
    if problems or (found is not None and found["findings"]):
        raise typer.Exit(1)


def _compare(skill: SkillManifest, stats: Path, embodiment: str) -> dict[str, Any]:
    read = read_checkpoint_stats(stats, named_outputs(skill), embodiment)
    findings = contract_findings(skill.action_contract, read.actions)
    return {"file": str(stats), "form": read.form, "findings": findings}


def _print(skill: str, robot: str, problems: list[str], folder: Path) -> None:
    if problems:
        echo(f"{skill} cannot run on {robot}:\n  " + "\n  ".join(problems))
        echo(f"fix {folder / 'rskill.yaml'}, then: fairlead skill check {skill}")
    else:
        echo(f"{skill} may run on {robot}")


def _print_findings(skill: str, found: dict[str, Any]) -> None:
    if found["findings"]:
        listed = "\n  ".join(found["findings"])
        echo(f"{skill} does not fit what {found['file']} was trained on:\n  {listed}")
    else:
        echo(f"{skill} fits what {found['file']} ({found['form']}) was trained on")


def _running(deployment: Path | None) -> HalStatus | None:
    if deployment is None:
        return None
    with RobotClient(load_deployment(deployment)) as client:
        return client.hal_status()
