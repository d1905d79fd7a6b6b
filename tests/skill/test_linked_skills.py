"""A skill that is linked instead of copied: ``skill install --link``, ``run FOLDER``."""

from __future__ import annotations

from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.paths import repo_root, rskill_dir
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import find_skill, load_skill, skill_ids
from fairlead_tools.cli.skill import installed_skill
from fairlead_tools.skills.install import install_skill
from fairlead_tools.skills.skeleton import skill_skeleton
from tests.cli.command import fairlead_here


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's skills: an empty place of this test's own."""
    folder = tmp_path / "data" / "rskills"
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(folder))
    return folder


def written(folder: Path) -> Path:
    """A skeleton in ``folder``, as `skill new` writes it."""
    folder.mkdir(parents=True)
    for file, text in skill_skeleton(folder.name, load_robot("panda_mobile")).items():
        (folder / file).write_text(text, encoding="utf-8")
    return folder


def test_a_linked_skill_is_its_folder_and_a_copy_replaces_the_link_only_by_force(
    installed: Path, tmp_path: Path
) -> None:
    folder = written(tmp_path / "mine")
    assert install_skill(folder, link=True) == installed / "mine"
    manifest = folder / "rskill.yaml"
    manifest.write_text(manifest.read_text().replace("version: 0.1.0", "version: 0.2.0"))
    assert load_skill("mine").version == "0.2.0"
    assert install_skill(folder, link=True).is_symlink(), "the same link again needs no force"
    copied = fairlead_here("skill", "install", str(folder), state=tmp_path)
    assert (copied.returncode, copied.stderr) == (
        1,
        f"ERROR skill mine: {installed}/mine is a link to {folder}, whose edits need no new "
        "install; replace the link with --force\n",
    )
    other = written(tmp_path / "other" / "mine")
    with pytest.raises(ConfigError, match=f"is a link to {folder}, "):
        install_skill(other, link=True)
    assert (installed / "mine").resolve() == folder
    install_skill(folder, force=True)
    assert not (installed / "mine").is_symlink() and load_skill("mine").version == "0.2.0"
    assert (folder / "rskill.yaml").is_file()


def test_the_advice_with_a_new_skill_makes_a_runner_use_what_is_edited(
    installed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_ROOT", str(repo_root()))
    monkeypatch.chdir(tmp_path)
    made = fairlead_here("skill", "new", "my-wave", "--robot", "panda_mobile", state=tmp_path)
    advice = made.stdout.splitlines()[-1].removeprefix("next: fairlead ")
    assert f"fairlead {advice}\n" in (repo_root() / "docs" / "my-first-skill.md").read_text()
    assert fairlead_here(*advice.split(), state=tmp_path).returncode == 0
    assert rskill_dir("my-wave").resolve() == tmp_path / "my-wave"


def test_a_link_that_leads_nowhere_is_replaced_and_hides_nothing(
    installed: Path, tmp_path: Path
) -> None:
    folder = written(tmp_path / "mine")
    install_skill(folder, link=True)
    moved = folder.rename(tmp_path / "data" / "mine")
    assert "mine" not in skill_ids()
    with pytest.raises(ConfigError, match=f"expected a folder with rskill.yaml .* got {folder};"):
        find_skill("mine")
    install_skill(moved)
    assert load_skill("mine").id == "mine"


def test_run_links_a_folder_and_refuses_one_beside_another_of_its_name(
    installed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = written(tmp_path / "mine")
    assert installed_skill(str(folder)) == "mine"
    assert capsys.readouterr().err == f"linked {installed}/mine -> {folder}\n"
    assert installed_skill(str(folder)) == installed_skill("mine") == "mine"
    assert capsys.readouterr().err == ""
    other = written(tmp_path / "other" / "mine")
    with pytest.raises(ConfigError) as caught:
        installed_skill(str(other))
    assert str(caught.value) == (
        f"skill mine: another one is installed in {installed}/mine; replace it by this one with: "
        f"fairlead skill install --link --force {other}"
    )


def test_the_installed_copy_is_not_linked_to_itself(installed: Path, tmp_path: Path) -> None:
    install_skill(written(tmp_path / "mine"))
    copy = installed / "mine"
    assert installed_skill(str(copy)) == "mine", "which it is already"
    with pytest.raises(ConfigError, match="is where it is installed; link another one"):
        install_skill(copy, link=True)
    assert (copy / "policy.py").is_file() and not copy.is_symlink()


def test_a_folder_that_ships_is_the_skill_that_ships() -> None:
    assert installed_skill(str(find_skill("go-to"))) == "go-to"
