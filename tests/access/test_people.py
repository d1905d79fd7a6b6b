"""Who commands a robot is a person whose certificate says so, where its file lists people."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml
from pydantic import ValidationError

from fairlead.deploy.access import rights
from fairlead.deploy.certificates import certificates_dir
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError
from fairlead.operate.asker import OPERATOR_VARIABLE, asker, person_here
from fairlead.operate.client import RobotClient
from fairlead.paths import ACCESS_VARIABLE, repo_root
from fairlead_tools.certificates.authority import Authority
from tests.access.certified import PEOPLE, account
from tests.cli.command import fairlead_here

ONE_HOST = repo_root() / "compose" / "panda_mobile_sim.yaml"


@pytest.fixture
def file(file: Path) -> Path:
    """The same with people."""
    content = yaml.safe_load(file.read_text(encoding="utf-8")) | {"people": PEOPLE}
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return file


def changed(file: Path, **changes: object) -> Deployment:
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    return Deployment.model_validate(content | changes)


@pytest.mark.parametrize(
    ("people", "problem"),
    [
        (["ada", "ada"], "people: ada: another has this name; each person needs an own one"),
        (["gpu"], "people: gpu: another has this name"),
        (["runner"], "people: runner: another has this name"),
        (["operator"], "people: operator: tools have this name; give another one"),
        (["router"], "people: router: the router itself has this name; give another one"),
        (["ada.l"], "people: 'ada.l': expected a name of a-z 0-9 _ -"),
        (
            ["a" * 60],
            f"people: {'a' * 60}: fl/certified/{'a' * 60} is longer than the 64 signs that",
        ),
    ],
)
def test_a_name_that_is_another_s_or_none_is_refused(
    file: Path, people: list[str], problem: str
) -> None:
    with pytest.raises(ValidationError, match=re.escape(problem)):
        changed(file, people=people)


def test_on_one_host_nothing_proves_a_person(file: Path) -> None:
    content = yaml.safe_load(ONE_HOST.read_text(encoding="utf-8")) | {"people": PEOPLE}
    with pytest.raises(ValidationError, match="certificates prove them, which are for hosts and a"):
        Deployment.model_validate(content)
    opened = changed(file, access="open")
    assert opened.parties.people == ()
    assert opened.open_access.endswith("may move the robot; no certificate proves its people")


def test_commands_are_a_persons_and_all_else_stays_the_tools(file: Path) -> None:
    listed = {(one.key, one.kind): one.write for one in rights(load_deployment(file).parties)}
    nobody = {(one.key, one.kind): one.write for one in rights(changed(file, people=[]).parties)}
    robot = "fl/certified"
    commands = ["safety/cmd/arm", "safety/cmd/disarm", "safety/cmd/reset", "hal/cmd/reset_episode"]
    commands += [f"skill/runner/{verb}" for verb in ("goal", "cancel", "load")]
    commands += ["safety/cmd/claim/*"]
    for command in commands:
        key = f"{robot}/{command}"
        assert (key, "query") not in listed
        assert nobody.pop((key, "query")) == ["operator"]
        for person in PEOPLE:
            assert listed.pop((f"{key}/{person}", "query")) == [person]
    assert listed.keys() == nobody.keys()
    for one, names in nobody.items():
        assert listed[one] == [*names, *(PEOPLE if "operator" in names else ())]


def test_each_person_has_a_certificate_in_a_folder_of_their_own(file: Path, tmp_path: Path) -> None:
    def certs(*words: str) -> str:
        done = fairlead_here("certs", words[0], str(file), *words[1:], state=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout

    made = certs("new")
    assert "ada/ada, ben/ben" in made
    folder = certificates_dir(load_deployment(file).keys)
    assert (
        "ada needs, in an account that nobody else uses, at the same place below its home" in made
    )
    assert f"the folder {folder / 'ada'}: whoever can read it is ada\n" in made
    assert {one.name for one in (folder / "ada").iterdir()} == {"ada.pem", "router.ca"}
    assert not (folder / "gpu" / "ada.pem").exists()
    assert certs("renew", "ada").startswith("renewed ada/ada\n")
    assert certs("revoke", "ben").startswith("revoked ben/ben\n")
    shown = {line.split()[1]: line.split("UTC")[-1].split() for line in certs("show").splitlines()}
    assert (shown["ada"], shown["ben"][-2:]) == (["valid"], ["none", "here"])


def test_who_has_left_the_list_is_revoked(authority: Authority, file: Path) -> None:
    assert Authority(changed(file, people=["ada"])).left == [("ben", "ben")]
    assert authority.left == []


HERE: dict[str, tuple[tuple[str, ...], str | None, str, str]] = {
    "ada's alone": (("ada",), None, "mia", "ada"),
    "ada's, who says so": (("ada",), "ada", "mia", "ada"),
    "both, ben's user": (("ada", "ben"), None, "ben", "ben"),
    "both, ben is named": (("ada", "ben"), "ben", "ada", "ben"),
    "both, and another user": (("ada", "ben"), None, "mia", ""),
    "nobody's": (("gpu",), None, "ada", ""),
}


@pytest.mark.parametrize("situation", HERE)
def test_tools_are_the_person_whose_certificate_is_here(
    situation: str, authority: Authority, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names, named, user, expected = HERE[situation]
    monkeypatch.setenv(ACCESS_VARIABLE, str(account(tmp_path, authority.deployment, *names)))
    monkeypatch.setattr("getpass.getuser", lambda: user)
    monkeypatch.delenv(OPERATOR_VARIABLE, raising=False)
    if named is not None:
        monkeypatch.setenv(OPERATOR_VARIABLE, named)
    assert person_here(authority.deployment) == expected
    assert asker(authority.deployment, "x").startswith(f"{expected or user}@")


@pytest.mark.parametrize("named", ["ben", "mia"])
def test_no_tool_says_another_name_than_its_certificates(
    named: str, authority: Authority, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(ACCESS_VARIABLE, str(account(tmp_path, authority.deployment, "ada")))
    monkeypatch.setenv(OPERATOR_VARIABLE, named)
    said = (
        f"FAIRLEAD_OPERATOR: deployment certified: expected a person whose certificate is here, "
        f"got {named} (valid: ada)"
    )
    with pytest.raises(ConfigError, match=re.escape(said)):
        RobotClient(authority.deployment)
