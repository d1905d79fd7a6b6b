"""Where robots, skills, deployment files and the gate lie: one tree, wherever it comes from.

A checkout is such a tree, and a wheel carries one inside the package, in ``fairlead/data``:

    robots/  rskills/  compose/  build/safety/fairlead-safety  requirements-run.lock

``FAIRLEAD_ROOT`` names the tree; without it the first one is taken that is found from the
working directory upwards and that nobody else may write (it brings the gate), then inside
this package, then from this package upwards (an editable install, whose package lies in its
checkout). What belongs to the user lies outside of it: skills in ``FAIRLEAD_SKILLS``, robots
in ``FAIRLEAD_ROBOTS`` and calibrations in ``FAIRLEAD_CALIBRATIONS``, else in the user's data
folder. What runs keeps its state in ``FAIRLEAD_STATE``, passwords and certificates in
``FAIRLEAD_ACCESS``, else in the user's state folder. Other installed packages may have ``robots/``,
``rskills/`` and ``compose/`` too, in a folder that they register in ``fairlead.data``.

Of one name, what ships comes first, then what is the user's, then what packages bring.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from fairlead.errors import ConfigError, expected
from fairlead.plugins import data_folders

ROOT_VARIABLE = "FAIRLEAD_ROOT"
SKILLS_VARIABLE = "FAIRLEAD_SKILLS"
ROBOTS_VARIABLE = "FAIRLEAD_ROBOTS"
CALIBRATIONS_VARIABLE = "FAIRLEAD_CALIBRATIONS"
STATE_VARIABLE = "FAIRLEAD_STATE"
ACCESS_VARIABLE = "FAIRLEAD_ACCESS"
PACKAGED_TREE = "data"
_LONGEST_NAME = 255  # bytes, of a folder


def repo_root() -> Path:
    """The folder that holds ``robots/`` and ``rskills/``.

    Raises:
        ConfigError: naming every folder that was looked at.
    """
    looked_at: list[str] = []
    for folder in _candidates():
        if _is_tree(folder):
            return folder
        looked_at.append(str(folder))
    raise ConfigError(
        "fairlead: expected a checkout with the folders robots/ and rskills/, looked at "
        f"{', '.join(looked_at)}; run inside the checkout or set {ROOT_VARIABLE}"
    )


def robot_dir(robot: str) -> Path:
    """Folder of one robot.

    Raises:
        ConfigError: naming the folder looked for and the robots there are.
    """
    return _named_dir("robot", robot, robot_folders(), "robot.yaml")


def rskill_dir(skill: str) -> Path:
    """Folder of one skill.

    Raises:
        ConfigError: naming the folder looked for and the skills there are.
    """
    return _named_dir("skill", skill, skill_folders(), "rskill.yaml")


def user_skills_dir() -> Path:
    """Where ``fairlead skill install`` puts skills; it need not exist yet."""
    return _users_own(SKILLS_VARIABLE, "rskills")


def user_calibrations_dir() -> Path:
    """Where ``fairlead calibrate`` puts what it found of an arm; it need not exist yet."""
    return _users_own(CALIBRATIONS_VARIABLE, "calibrations")


def user_state_dir() -> Path:
    """Where what runs on this machine is listed, and keeps its logs and state."""
    override = os.environ.get(STATE_VARIABLE)
    return Path(override).absolute() if override else _in_home("XDG_STATE_HOME", ".local/state")


def user_access_dir() -> Path:
    """Where passwords and certificates of deployments are."""
    override = os.environ.get(ACCESS_VARIABLE)
    return Path(override).absolute() if override else user_state_dir() / "access"


def access_variable() -> str:
    """Of the environment: what names another place for `user_access_dir`."""
    return ACCESS_VARIABLE if os.environ.get(ACCESS_VARIABLE) else STATE_VARIABLE


def skill_folders() -> tuple[Path, ...]:
    """Folders of skills, those that ship first: no other skill takes their name."""
    return (repo_root() / "rskills", user_skills_dir(), *_packaged("rskills"))


def user_robots_dir() -> Path:
    """Where ``fairlead robot new`` puts robots; it need not exist yet."""
    return _users_own(ROBOTS_VARIABLE, "robots")


def robot_folders() -> tuple[Path, ...]:
    """Folders of robots, those that ship first: no other robot takes their name."""
    return (repo_root() / "robots", user_robots_dir(), *_packaged("robots"))


def robot_ids() -> tuple[str, ...]:
    """Ids of every robot that ships and of every one of the user's own, sorted."""
    found = {path.parent.name for one in robot_folders() for path in one.glob("*/robot.yaml")}
    return tuple(sorted(found))


def deployment_path(wanted: str) -> Path:
    """The deployment file a person means: a path, or the name of one that is installed.

    Raises:
        ConfigError: there is neither, naming the deployments there are; the path may not be seen.
    """
    with suppress(OSError):  # the folder that we are in may not be entered; a name is too long
        if Path(wanted).is_file():
            return Path(wanted)
    known = {path.stem: path for path in reversed(deployment_files())}
    if "/" not in wanted and (named := known.get(wanted.removesuffix(".yaml"))):
        return named
    try:
        there = Path(wanted).exists() or Path(wanted).is_symlink()
    except OSError as error:
        raise ConfigError(f"deployment {wanted!r}: {error.strerror}") from None
    none = "no file that can be read" if there else "no such file"  # a folder, a ring of links
    raise ConfigError(
        f"deployment {wanted!r}: {none}, and none of that name in {repo_root() / 'compose'} "
        f"(valid: {', '.join(deployment_names()) or 'none'}, or a path)"
    )


def deployment_files() -> list[Path]:
    """Every deployment file, those that ship first, then those of packages."""
    folders = (repo_root() / "compose", *_packaged("compose"))
    return [path for folder in folders for path in sorted(folder.glob("*.yaml"))]


def deployment_names() -> list[str]:
    """Names of all deployment files, sorted."""
    return sorted({path.stem for path in deployment_files()})


def gate_config(robot: str, profile: str) -> Path:
    """The compiled gate file of a robot and profile.

    Raises:
        ConfigError: if it has not been compiled.
    """
    path = robot_dir(robot) / f"gate.{profile}.json"
    if not path.is_file():
        raise ConfigError(
            f"robot {robot}: no compiled gate file {path}; if robot.yaml has the safety profile "
            f"{profile!r}, make it with: fairlead robot compile {robot}"
        )
    return path


def gate_binary() -> Path:
    """The built safety gate; raises as `built_program` does."""
    return built_program("fairlead-safety")


def decisions_binary() -> Path:
    """The program beside the gate that reads decision logs; raises as `built_program` does."""
    return built_program("fairlead-decisions")


def built_program(program: str) -> Path:
    """A program of the gate's build; ``FAIRLEAD_GATE_DIR`` names a folder with another one.

    Raises:
        ConfigError: if it has not been built.
    """
    folder = Path(os.environ.get("FAIRLEAD_GATE_DIR") or repo_root() / "build" / "safety")
    path = folder.absolute() / program
    if not path.is_file():
        raise ConfigError(f"safety gate: no binary at {path}; build it with: scripts/build-gate")
    return path


def runtime_lock() -> Path:
    """The lock file of every package fairlead runs on, robosuite included."""
    return repo_root() / "requirements-run.lock"


def make_private(folder: Path) -> None:
    """Make a folder, and those above it that there are not yet, for this user alone."""
    if not folder.is_dir():
        make_private(folder.parent)
        folder.mkdir(mode=0o700, exist_ok=True)


@contextmanager
def written(file: Path, draft: Path) -> Iterator[None]:
    """Have what keeps a file from being written name it, as no full disk does; no half is left.

    draft: what is written first, to take the file's place: the file itself where there is none.
    """
    try:
        yield
    except OSError as error:
        if draft != file or error.filename is None:  # else it was not opened, and is as it was
            with suppress(OSError):
                draft.unlink(missing_ok=True)
        if error.filename is None:
            error.filename = str(file)
        raise


def _is_tree(folder: Path) -> bool:
    """A Python package that has robots and skills is some package's data, not a checkout."""
    has_both = (folder / "robots").is_dir() and (folder / "rskills").is_dir()
    return has_both and not (folder / "__init__.py").is_file()


def _is_own(folder: Path) -> bool:
    """Nobody but this user and root may put anything there."""
    try:
        status = folder.stat()
    except OSError:  # who may not look at it has no tree there
        return False
    return status.st_uid in (0, os.geteuid()) and not status.st_mode & 0o002


def _candidates() -> Iterator[Path]:
    override = os.environ.get(ROOT_VARIABLE)
    if override:
        yield Path(override)
        return
    with suppress(FileNotFoundError):  # it has been deleted, which is no reason not to stop a robot
        here = Path.cwd()
        yield from filter(_is_own, (here, *here.parents))
    package = Path(__file__).resolve().parent
    yield package / PACKAGED_TREE
    yield from package.parents


def _packaged(folder: str) -> list[Path]:
    return [place / folder for place in data_folders()]


def _users_own(variable: str, folder: str) -> Path:
    override = os.environ.get(variable)
    return Path(override) if override else _in_home("XDG_DATA_HOME", ".local/share") / folder


def _in_home(variable: str, default: str) -> Path:
    """Our part of one of the user's folders; as XDG has it, a relative path is none."""
    named = Path(os.environ.get(variable, ""))
    try:
        return (named if named.is_absolute() else Path.home() / default) / "fairlead"
    except RuntimeError:
        wanted = f"{variable} or HOME as an absolute path: uid {os.geteuid()} has no home"
        raise ConfigError(expected("fairlead", wanted, "neither")) from None


def _named_dir(what: str, name: str, parents: Sequence[Path], manifest: str) -> Path:
    try:
        return _find_named(what, name, parents, manifest)
    except OSError as error:  # one that may not be entered, or whose network drive is gone
        raise ConfigError(
            f"{what} {name!r}: cannot look at {error.filename}: {error.strerror}"
        ) from None


def _find_named(what: str, name: str, parents: Sequence[Path], manifest: str) -> Path:
    fits = name and len(name.encode(errors="replace")) < _LONGEST_NAME  # else looking is an error
    if fits and "/" not in name:
        for parent in parents[:2]:
            if (parent / name / manifest).is_file():
                return parent / name
        packaged = [one / name for one in parents[2:] if (one / name / manifest).is_file()]
        if len(packaged) > 1:
            owners = " and ".join(map(str, packaged))
            raise ConfigError(f"{what} {name!r}: {owners} have it; uninstall one of the packages")
        if packaged:
            return packaged[0]
    files = [one for parent in parents for one in parent.glob(f"*/{manifest}") if one.is_file()]
    known = sorted({one.parent.name for one in files})
    valid = f"(valid: {', '.join(known) or 'none'})"
    if "/" in name:
        own = {"robot": ROBOTS_VARIABLE, "skill": SKILLS_VARIABLE}[what]
        raise ConfigError(
            f"{what} {name!r}: expected a name, not a path; {own} names a folder of more {valid}"
        )
    begun = [parent for parent in parents if fits and (parent / name).is_dir()]
    raise ConfigError(f"{what} {name!r}: no file {(begun or parents)[0] / name / manifest} {valid}")
