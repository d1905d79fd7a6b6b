"""Finding robots, skills and binaries, and what is said when they are not there."""

import os
from pathlib import Path

import pytest

from fairlead import paths
from fairlead.errors import ConfigError
from fairlead.paths import (
    deployment_path,
    gate_binary,
    gate_config,
    repo_root,
    robot_dir,
    rskill_dir,
)
from fairlead.skill.manifest import find_skill
from fairlead_tools.supervisor.slot import digests


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "robots" / "one").mkdir(parents=True)
    (tmp_path / "robots" / "one" / "robot.yaml").touch()
    (tmp_path / "rskills").mkdir()
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(tmp_path / "own"))
    return tmp_path


def test_root_is_found_from_a_folder_inside_the_checkout(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("FAIRLEAD_ROOT")
    monkeypatch.chdir(checkout / "robots" / "one")
    assert repo_root() == checkout


@pytest.mark.parametrize("how", ["of another user", "that others may write"])
def test_root_is_no_folder_into_which_others_may_have_put_a_gate(
    checkout: Path, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    monkeypatch.delenv("FAIRLEAD_ROOT")
    monkeypatch.chdir(checkout / "robots" / "one")
    if how == "that others may write":
        checkout.chmod(0o777)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: checkout.stat().st_uid + 1)
        if checkout.stat().st_uid == 0:
            os.chown(checkout, 12345, 12345)
    assert repo_root() != checkout


def test_root_is_found_from_anywhere_through_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("FAIRLEAD_ROOT", raising=False)
    monkeypatch.chdir(tmp_path)
    assert (repo_root() / "shared" / "fairlead").is_dir()


def test_root_that_is_no_checkout_says_where_it_looked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    with pytest.raises(ConfigError) as error:
        repo_root()
    assert str(error.value) == (
        "fairlead: expected a checkout with the folders robots/ and rskills/, looked at "
        f"{tmp_path}; run inside the checkout or set FAIRLEAD_ROOT"
    )


def test_root_is_the_tree_a_wheel_carries_inside_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "site-packages" / "fairlead"
    for folder in ("robots", "rskills"):
        (package / "data" / folder).mkdir(parents=True)
    monkeypatch.delenv("FAIRLEAD_ROOT", raising=False)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(paths, "__file__", str(package / "paths.py"))
    assert repo_root() == package / "data"


def test_a_robot_of_the_users_own_is_found_but_never_takes_a_shipped_name(checkout: Path) -> None:
    for name in ("one", "mine"):
        (checkout / "own" / name).mkdir(parents=True)
        (checkout / "own" / name / "robot.yaml").touch()
    assert robot_dir("mine") == checkout / "own" / "mine"
    assert robot_dir("one") == checkout / "robots" / "one"


def test_a_deployment_is_found_by_its_path_and_by_its_name(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (checkout / "compose").mkdir()
    shipped = checkout / "compose" / "one.yaml"
    shipped.touch()
    monkeypatch.chdir(checkout / "robots")
    assert deployment_path("one") == deployment_path("one.yaml") == shipped
    assert deployment_path("../compose/one.yaml") == Path("../compose/one.yaml")
    Path("one.yaml").touch()
    assert deployment_path("one.yaml") == Path("one.yaml")
    with pytest.raises(ConfigError) as error:
        deployment_path("compose/one.yaml")
    assert str(error.value) == (
        "deployment 'compose/one.yaml': no such file, and none of that name in "
        f"{checkout}/compose (valid: one, or a path)"
    )
    Path("a.yaml").mkdir()
    Path("b.yaml").symlink_to("b.yaml")
    for name in ("a.yaml", "b.yaml"):
        with pytest.raises(ConfigError, match=rf"^deployment '{name}': no file that can be read, "):
            deployment_path(name)
    with pytest.raises(ConfigError, match="^deployment 'x+': File name too long$"):
        deployment_path("x" * 5000)


def test_unknown_robot_lists_the_robots(checkout: Path) -> None:
    assert robot_dir("one") == checkout / "robots" / "one"
    with pytest.raises(ConfigError) as error:
        robot_dir("two")
    assert str(error.value) == (
        f"robot 'two': no file {checkout}/robots/two/robot.yaml (valid: one)"
    )


def test_unknown_skill_says_that_there_is_none(checkout: Path) -> None:
    with pytest.raises(ConfigError) as error:
        rskill_dir("pick")
    assert str(error.value) == (
        f"skill 'pick': no file {checkout}/rskills/pick/rskill.yaml (valid: none)"
    )


def test_a_folder_that_cannot_be_looked_into_is_one_error_and_hides_nothing_that_ships(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = checkout / ("x" * 300)  # looking at it is an error to any user
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(broken))
    assert robot_dir("one") == checkout / "robots" / "one"
    with pytest.raises(ConfigError) as error:
        robot_dir("two")
    assert str(error.value) == (
        f"robot 'two': cannot look at {broken}/two/robot.yaml: File name too long"
    )


def test_name_cannot_leave_its_folder(checkout: Path) -> None:
    with pytest.raises(ConfigError, match=r"robot '\.\./robots/one': expected a name, not a path"):
        robot_dir("../robots/one")


def test_missing_gate_file_names_the_command_that_makes_it(checkout: Path) -> None:
    with pytest.raises(ConfigError) as error:
        gate_config("one", "sim")
    assert str(error.value) == (
        f"robot one: no compiled gate file {checkout}/robots/one/gate.sim.json; "
        "if robot.yaml has the safety profile 'sim', make it with: "
        "fairlead robot compile one"
    )


def test_missing_gate_binary_names_the_command_that_builds_it(checkout: Path) -> None:
    with pytest.raises(ConfigError) as error:
        gate_binary()
    assert str(error.value) == (
        f"safety gate: no binary at {checkout}/build/safety/fairlead-safety; build it with: "
        "scripts/build-gate"
    )


def test_of_the_user_s_folders_a_relative_one_is_none_as_xdg_has_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for variable in ("FAIRLEAD_STATE", "FAIRLEAD_ROBOTS"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", "state")
    monkeypatch.setenv("XDG_DATA_HOME", "data")
    assert paths.user_state_dir() == tmp_path / ".local" / "state" / "fairlead"
    assert paths.user_robots_dir() == tmp_path / ".local" / "share" / "fairlead" / "robots"


def test_a_user_without_a_home_is_told_what_to_set(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    for variable in ("FAIRLEAD_STATE", "XDG_STATE_HOME"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setattr(Path, "home", no_home)
    said = "fairlead: expected XDG_STATE_HOME or HOME as an absolute path: uid [0-9]+ has no home, "
    with pytest.raises(ConfigError, match=said + "got neither"):
        paths.user_state_dir()


def test_what_has_a_name_is_found_from_a_folder_that_may_not_be_entered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As after ``sudo -u fairlead`` in one's own home."""
    real = Path.stat

    def stat(path: Path, **options: bool) -> os.stat_result:
        if not path.is_absolute():
            raise PermissionError(13, "Permission denied", str(path))
        return real(path, **options)

    monkeypatch.setattr(Path, "stat", stat)
    assert deployment_path("panda_mujoco") == repo_root() / "compose" / "panda_mujoco.yaml"
    assert find_skill("panda-joint-reach") == rskill_dir("panda-joint-reach")
    assert digests(["gate", "--listen", "unixsock-stream//folder/safety.sock"]) == {}
    with pytest.raises(ConfigError, match=r"^deployment 'mine\.yaml': Permission denied$"):
        deployment_path("mine.yaml")
