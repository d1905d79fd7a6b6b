"""Install a skill: check everything first, then put its folder among the user's skills."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from fairlead.checked_model import MisfitError
from fairlead.errors import ConfigError
from fairlead.paths import SKILLS_VARIABLE, repo_root, user_skills_dir
from fairlead.regular_file import regular
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import SkillManifest, of_options, read_skill
from fairlead.skill.python_policy import BACKEND, check_python_policy
from fairlead.yaml_file import locator


def install_problems(folder: Path, skill: SkillManifest, known: Sequence[str]) -> list[str]:
    """Every reason against installing a skill, for each robot it says it was made for.

    known: those against its policy that the caller knows of.
    """
    problems = []
    for robot in skill.embodiments:
        try:
            found = admission_problems(skill, load_robot(robot))
        except ConfigError as error:
            found = [str(error)]
        problems += [f"on {robot}: {problem}" for problem in found]
    return problems + (list(known) or python_problems(folder, skill))


def python_problems(folder: Path, skill: SkillManifest) -> list[str]:
    """What is missing of a policy that is a Python file of the skill's folder; empty if nothing."""
    if skill.policy.backend != BACKEND:
        return []
    try:
        check_python_policy(folder, skill.policy.options)
    except MisfitError as error:
        return [str(error.located(of_options(locator(folder / "rskill.yaml"))))]
    except ConfigError as error:
        return [str(error)]
    return []


def policy_problems(skill: SkillManifest, folder: Path) -> list[str]:
    """Why the policy of the skill in a folder cannot be loaded with its options, if it cannot."""
    from fairlead_skill_runner import check_policy_options

    try:
        check_policy_options(skill, locator(folder / "rskill.yaml"), folder)
    except ConfigError as error:
        return [str(error)]
    return []


def require_own_name(skill_id: str) -> None:
    """Raises `ConfigError` for the name of a skill that ships: of two, that one is found."""
    if (repo_root() / "rskills" / skill_id).exists():
        raise ConfigError(f"skill {skill_id}: one of this name ships with fairlead; rename yours")


def install_skill(
    folder: Path, force: bool = False, found: Sequence[str] = (), link: bool = False
) -> Path:
    """Check the skill in ``folder`` and put it where `load_skill` finds it.

    The same version is replaced, and a link to the same folder; another version, and a link by
    anything else, only with ``force``.

    Args:
        link: a link to the folder instead of a copy, so that its edits are the skill's.
        found: reasons against it that the caller knows of.

    Returns:
        Where it is installed.

    Raises:
        ConfigError: with every reason why not; nothing has been written then.
    """
    skill = read_skill(folder)
    if problems := install_problems(folder, skill, found):
        raise ConfigError(f"skill {skill.id} is not installed:\n  " + "\n  ".join(problems))
    require_own_name(skill.id)
    target = user_skills_dir() / skill.id
    if link and not target.is_symlink() and target.resolve() == folder.resolve():
        raise ConfigError(f"skill {skill.id}: {target} is where it is installed; link another one")
    if not (link and is_link_to(target, folder)):
        _check_version(target, skill, force)
    try:
        _put(folder, target, link)
    except OSError as error:
        # That of a folder has a list of what went wrong with each file.
        why = error.args[0][0][2] if isinstance(error, shutil.Error) else error.strerror or error
        raise ConfigError(
            f"skill {skill.id}: cannot write {target}: {why}; another folder: set {SKILLS_VARIABLE}"
        ) from None
    return target


def _check_version(target: Path, skill: SkillManifest, force: bool) -> None:
    if not target.exists() or force:
        return
    if target.is_symlink():
        raise ConfigError(
            f"skill {skill.id}: {target} is a link to {target.resolve()}, whose edits need no new "
            "install; replace the link with --force"
        )
    installed = read_skill(target).version
    if installed != skill.version:
        raise ConfigError(
            f"skill {skill.id}: version {installed} is installed in {target}, this one is "
            f"{skill.version}; replace it with --force"
        )


def is_link_to(target: Path, folder: Path) -> bool:
    """Whether an installed skill is a link to this folder."""
    return target.is_symlink() and target.resolve() == folder.resolve()


def _copy(source: str, target: str) -> None:
    try:
        regular(Path(source)).open("rb").close()
    except OSError as error:
        raise ConfigError(f"skill install: {source}: cannot be read: {error.strerror}") from None
    shutil.copy2(source, target)


def _put(folder: Path, target: Path, link: bool) -> None:
    """The new folder is complete before the old one goes."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".installing-") as beside:
        fresh = Path(beside) / target.name
        if link:
            fresh.symlink_to(folder.resolve(), target_is_directory=True)
        else:
            ignored = shutil.ignore_patterns("__pycache__", ".*")
            shutil.copytree(folder, fresh, ignore=ignored, copy_function=_copy)
        if target.exists() or target.is_symlink():
            target.rename(Path(beside) / "old")
        fresh.rename(target)
