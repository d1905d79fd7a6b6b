"""Finding robots, skills and binaries, and what is said when they are not there."""

from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.paths import gate_binary, gate_config, repo_root, robot_dir, rskill_dir


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "robots" / "one").mkdir(parents=True)
    (tmp_path / "robots" / "one" / "robot.yaml").touch()
    (tmp_path / "rskills").mkdir()
    monkeypatch.setenv("FAIRLEAD_ROOT", str(tmp_path))
    return tmp_path


def test_root_is_found_from_a_folder_inside_the_checkout(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("FAIRLEAD_ROOT")
    monkeypatch.chdir(checkout / "robots" / "one")
    assert repo_root() == checkout


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


def test_name_cannot_leave_its_folder(checkout: Path) -> None:
    with pytest.raises(ConfigError, match=r"robot '\.\./robots/one': no file"):
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
