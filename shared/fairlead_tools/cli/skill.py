"""``fairlead skill``: look at skills, check them against a robot, write and install them."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Any

import typer
import yaml

from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError, expected
from fairlead.messages import HalStatus
from fairlead.operate.client import RobotClient
from fairlead.paths import rskill_dir, user_skills_dir
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.admission import admission_problems, home_warnings, summarised
from fairlead.skill.manifest import (
    SkillManifest,
    find_backend,
    find_skill,
    load_skill,
    locate_in_skill,
    read_skill,
    skill_ids,
)
from fairlead.yaml_file import RowDumper
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.options import (
    JsonOption,
    RobotOption,
    SkillArgument,
    complete_robot,
    deployment_option,
    example,
    make_group,
)
from fairlead_tools.cli.running_deployments import running_robot
from fairlead_tools.skills.checkpoint_stats import (
    contract_findings,
    named_outputs,
    read_checkpoint_stats,
)
from fairlead_tools.skills.install import (
    install_skill,
    is_link_to,
    policy_problems,
    python_problems,
    require_own_name,
)
from fairlead_tools.skills.skeleton import ARM_MODES, skill_skeleton


def installed_skill(wanted: str) -> str:
    """The id of a skill that a person means; a folder is linked into the user's skills, and said.

    Raises:
        ConfigError: there is none, it does not fit, or another one of its name is installed.
    """
    if wanted in skill_ids():
        return wanted
    folder = find_skill(wanted)
    skill = read_skill(folder)
    target = user_skills_dir() / skill.id
    if skill.id in skill_ids() and rskill_dir(skill.id).resolve() == folder.resolve():
        return skill.id
    if not is_link_to(target, folder):
        if target.exists():
            raise ConfigError(
                f"skill {skill.id}: another one is installed in {target}; replace it by this one "
                f"with: fairlead skill install --link --force {shlex.quote(wanted)}"
            )
        install_skill(folder, found=policy_problems(skill, folder), link=True)
        echo(f"linked {target} -> {folder.resolve()}", err=True)
    return skill.id


@example("fairlead skill ls --robot panda_mobile")
def ls_command(
    robot: Annotated[
        str,
        typer.Option(
            help="the one that runs here, else panda_mobile", autocompletion=complete_robot
        ),
    ] = "",
    as_json: JsonOption = False,
) -> None:
    """Show every skill, shipped or installed: admitted on this robot, or dropped and why."""
    robot = robot or running_robot() or "panda_mobile"
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
        find_backend(skill.policy, locate_in_skill(name))
    except ConfigError as error:
        return [str(error)]
    return problems


WIDTH = 100


@example("fairlead skill show oracle-counter-to-cabinet")
def show_command(
    skill: SkillArgument,
    as_json: JsonOption = False,
) -> None:
    """Show a skill: its policy, what it needs as state, what its numbers mean."""
    manifest = read_skill(find_skill(skill))
    document = manifest.model_dump(mode="json") | {"skill_hash": manifest.skill_hash.hex()}
    if as_json:
        print_json(document)
    else:
        echo(yaml.dump(document, Dumper=RowDumper, sort_keys=False, width=WIDTH).rstrip())


@example("fairlead skill check oracle-counter-to-cabinet --robot panda_mobile")
def check_command(
    skill: SkillArgument,
    robot: Annotated[
        str, typer.Option(help="folder under robots/; default: the first the skill was made for")
    ] = "",
    deployment: Annotated[
        Path | None,
        deployment_option(
            "--deployment",
            "-d",
            what="also compare ranges, part order and cameras with a robot that runs: ",
            without="with none",
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
    loaded = load_robot(robot or manifest.embodiments[0])
    problems = admission_problems(manifest, loaded, _running(deployment))
    told = summarised(problems, manifest, loaded)
    wrong = policy_problems(manifest, folder) or python_problems(folder, manifest)
    problems, told = problems + wrong, told + wrong
    report: dict[str, Any] = {
        "skill": skill, "robot": loaded.id, "admitted": not problems, "reasons": problems,
        "warnings": [] if problems else home_warnings(manifest, loaded),
    }  # fmt: skip
    found = None if stats is None else _compare(manifest, stats, embodiment)
    if found is not None:
        report["statistics"] = found
    if as_json:
        print_json(report)
    else:
        _print(skill, loaded.id, told, folder)
        for text in report["warnings"]:
            echo(f"WARNING {text}")
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
        echo(f"fix {folder / 'rskill.yaml'}, then: fairlead skill check {shlex.quote(skill)}")
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


@example("fairlead skill new my-wave --robot panda_mobile")
def new_command(
    name: Annotated[str, typer.Argument(help="the skill's id, and the folder made here")],
    robot: RobotOption = "panda_mobile",
    mode: Annotated[
        str,
        typer.Option(
            help=f"{', '.join(ARM_MODES)}; default: the first of these the arm takes "
            "(one of joints where home is singular)"
        ),
    ] = "",
) -> None:
    """Write NAME/rskill.yaml and NAME/policy.py, a working skill to start from."""
    if mode and mode not in ARM_MODES:
        raise ConfigError(expected("skill new: --mode", "a mode", repr(mode), ARM_MODES))
    files = skill_skeleton(name, load_robot(robot), mode)
    require_own_name(name)
    folder = Path(name)
    if folder.exists():
        raise ConfigError(f"skill new: {folder} exists already; choose another name")
    try:
        folder.mkdir()
        for file, text in files.items():
            (folder / file).write_text(text, encoding="utf-8")
            echo(f"wrote {folder / file}")
    except OSError as error:
        raise ConfigError(
            f"skill new: cannot write {folder.absolute()}: {error.strerror}"
        ) from None
    echo(f"next: fairlead skill install --link {folder}")


@example("fairlead skill install --link my-wave")
def install_command(
    path: Annotated[
        Path, typer.Argument(exists=True, file_okay=False, help="folder that holds rskill.yaml")
    ],
    force: Annotated[
        bool, typer.Option("--force", help="replace another version of the skill, or a link")
    ] = False,
    link: Annotated[
        bool, typer.Option("--link", help="a link to the folder: its edits need no new install")
    ] = False,
) -> None:
    """Check a skill, with every reason if it does not fit, and copy it to the user's skills.

    They are in $FAIRLEAD_SKILLS, else ~/.local/share/fairlead/rskills. A runner offers it at its
    next goal.
    """
    target = install_skill(path, force, policy_problems(read_skill(path), path), link)
    echo(f"installed {target}" + (f" -> {target.resolve()}" if link else ""))
    echo(f"next: fairlead run {target.name}")


group = make_group(
    "skill",
    "List, show and check skills, write a new one, install it.",
    {"ls": ls_command, "show": show_command, "check": check_command, "new": new_command,
     "install": install_command},
)  # fmt: skip
