"""Install a skill: check everything first, then copy its folder to the user's skills."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from fairlead.errors import ConfigError
from fairlead.paths import SKILLS_VARIABLE, repo_root, user_skills_dir
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import SkillManifest, read_skill
from fairlead.skill.python_policy import BACKEND, check_python_policy


def install_problems(folder: Path, skill: SkillManifest) -> list[str]:
    """Every reason against installing a skill, for each robot it says it was made for."""
    problems = []
    for robot in skill.embodiments:
        try:
            found = admission_problems(skill, load_robot(robot))
        except ConfigError as error:
            found = [str(error)]
        problems += [f"on {robot}: {problem}" for problem in found]
    if skill.policy.backend == BACKEND:
        try:
            check_python_policy(folder, skill.policy.options)
        except ConfigError as error:
            problems.append(str(error))
    return problems


def install_skill(folder: Path, force: bool = False, found: Sequence[str] = ()) -> Path:
    """Check the skill in ``folder`` and copy it to where `load_skill` finds it.

    The same version is replaced, another version only with ``force``.

    Args:
        found: reasons against it that the caller knows of.

    Returns:
        The folder it was copied to.

    Raises:
        ConfigError: with every reason why not; nothing has been written then.
    """
    skill = read_skill(folder)
    problems = [*install_problems(folder, skill), *found]
    if problems:
        raise ConfigError(f"skill {skill.id} is not installed:\n  " + "\n  ".join(problems))
    if (repo_root() / "rskills" / skill.id).exists():
        raise ConfigError(f"skill {skill.id}: one of this name ships with fairlead; rename yours")
    target = user_skills_dir() / skill.id
    _check_version(target, skill, force)
    try:
        _copy(folder, target)
    except OSError as error:
        raise ConfigError(
            f"skill {skill.id}: cannot write {target}: {error.strerror or error}; "
            f"another folder: set {SKILLS_VARIABLE}"
        ) from None
    return target


def _check_version(target: Path, skill: SkillManifest, force: bool) -> None:
    if not target.exists() or force:
        return
    installed = read_skill(target).version
    if installed != skill.version:
        raise ConfigError(
            f"skill {skill.id}: version {installed} is installed in {target}, this one is "
            f"{skill.version}; replace it with --force"
        )


def _copy(folder: Path, target: Path) -> None:
    """The new folder is complete before the old one goes."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent.parent, prefix=".installing-") as beside:
        fresh = Path(beside) / target.name
        shutil.copytree(folder, fresh, ignore=shutil.ignore_patterns("__pycache__", ".*"))
        if target.exists():
            target.rename(Path(beside) / "old")
        fresh.rename(target)
