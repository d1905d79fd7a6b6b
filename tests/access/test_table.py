"""The table, and the passwords that prove a name."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from itertools import product
from pathlib import Path
from typing import NamedTuple, get_args

import pytest
from pydantic import ValidationError

from fairlead.deploy.access import (
    ALL,
    SERVICES,
    TABLE,
    Kind,
    Role,
    Row,
    grants,
    rights,
)
from fairlead.deploy.credentials import PASSWORDS, find_secrets
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError
from fairlead.keys import Keys, of_person
from fairlead.paths import ACCESS_VARIABLE, STATE_VARIABLE, repo_root

FILE = repo_root() / "compose" / "panda_mobile_sim.yaml"
KEYS = Keys("tested")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path / "access"))
    return tmp_path / "access" / "tested"


EVERYONE = frozenset(ALL)
TOOLS: frozenset[Role] = frozenset({"operator"})
WORDS: dict[str, frozenset[Role]] = {
    "everyone": frozenset(ALL),
    "services": frozenset(SERVICES),
    "each service": frozenset(SERVICES),
    **dict.fromkeys(("tools", "clients", "planners"), TOOLS),
    "skill_runner": frozenset({"runner"}),
    **dict.fromkeys(
        ("hal", "hal (simulators)", "camera process", "a simulator's hal", "a HAL that starts"),
        frozenset({"hal"}),
    ),
    "state_assembler": frozenset({"state_assembler"}),
    "localiser": frozenset({"localiser"}),
    **dict.fromkeys(("safety", "safety only"), frozenset({"safety"})),
}
"""Whom the words of keys.md mean."""


class Listed(NamedTuple):
    """A row of keys.md."""

    kind: str
    writers: frozenset[Role]
    readers: frozenset[Role]


def rows() -> list[tuple[str, str, str, str]]:
    """Key, kind, who writes and who reads, as a person wrote them down; `*` for what is in angle
    brackets, `@` for a person's name."""
    table = Path(__file__).with_name("keys.md").read_text(encoding="utf-8")
    assert "Tools may also read all that is published, and the tokens of" in table.replace(
        "\n", " "
    )
    found = re.findall(r"^\| `([^`]+)` \| (.+) \| (.+) \| (.+) \|$", table, re.M)
    short = [(re.sub("<[^>]+>", "*", keys.replace("<person>", "@")), *row) for keys, *row in found]
    return [(key, *row) for keys, *row in short for key in _spelt_out(keys)]


def listed() -> dict[str, Listed]:
    """By key, but those of people."""
    return {
        key: Listed(kind, _meant(writers), _meant(readers))
        for key, kind, writers, readers in rows()
        if not key.endswith("@")
    }


def test_it_has_the_key_of_a_person_for_each_command_that_is_listed() -> None:
    keys = {key.replace("@", "*") for key, *_ in rows() if key.endswith("@")}
    assert keys == {of_person(row.key, "*") for row in TABLE if row.person}


def _spelt_out(key: str) -> list[str]:
    parts = [part.split(",") for part in re.split("[{}]", key)]
    return ["".join(chosen) for chosen in product(*parts)]


def _meant(words: str) -> frozenset[Role]:
    plain = words.replace("*", "").partition(":")[0]
    return frozenset[Role]().union(*(WORDS[word] for word in plain.split(", ")))


def test_it_has_every_key_that_is_listed_and_of_each_the_kinds() -> None:
    assert {row.key for row in TABLE} == set(listed())
    for key, one in listed().items():
        kinds = {row.kind for row in TABLE if row.key == key}
        assert kinds == {kind for kind in get_args(Kind) if kind in one.kind}, key


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row.kind} {row.key}")
def test_who_may_do_what_is_what_is_listed(row: Row) -> None:
    one = listed()[row.key]
    writers, readers = set(row.writers), set(row.readers)
    if row.kind == "query" and "published" in one.kind:  # who may hear it may ask for it
        assert writers <= one.readers
        assert readers == one.writers
        return
    assert writers == one.writers
    is_published = row.kind == "published" or row.key == "camera/*/shared/*"
    assert readers == (one.readers | TOOLS if is_published else one.readers)


def test_only_the_gate_writes_what_the_hal_obeys_and_only_its_own_runner_a_source() -> None:
    found = {(one.key, one.kind): one.write for one in rights(load_deployment(FILE).parties)}
    robot = "fl/panda_mobile"
    assert found[f"{robot}/action/safe/*", "published"] == ["safety"]
    assert found[f"{robot}/safety/lease", "published"] == ["safety"]
    assert found[f"{robot}/action/candidate/runner", "published"] == ["runner"]
    assert found[f"{robot}/safety/cmd/arm", "query"] == ["operator"]


def test_nobody_may_delete() -> None:
    messages = {m for one in grants(load_deployment(FILE).parties) for m in one.messages}
    assert "delete" not in messages
    assert len(messages) == 8


def test_whatever_the_order_in_the_file_the_hal_dials_nobody_and_the_gate_only_it() -> None:
    deployment = load_deployment(FILE)
    services = dict(reversed(deployment.services.items()))
    turned = deployment.model_copy(update={"services": services})
    for one in (deployment, turned):
        assert one.endpoints("hal").connect == []
        assert one.endpoints("safety").connect == [one.listen("hal")]
        assert len(one.endpoints("runner").connect) == 3


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"localiser": "operator"}, "localiser: tools have this name"),
        ({"access": "shut"}, "Input should be 'closed' or 'open'"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, str], problem: str) -> None:
    content = load_deployment(FILE).model_dump(mode="json", exclude_unset=True)
    with pytest.raises(ValidationError, match=re.escape(problem)):
        Deployment.model_validate(content | changes)


def test_who_is_no_party_has_no_session() -> None:
    with pytest.raises(ConfigError, match="expected a party, got nobody"):
        load_deployment(FILE).tool_endpoints("nobody")


def test_passwords_are_made_once_for_this_user_alone_and_new_parties_get_theirs(
    folder: Path,
) -> None:
    folder.mkdir(parents=True)  # as whoever copies certificates to it does
    first = find_secrets(KEYS, ["hal", "operator"])
    assert find_secrets(KEYS, ["hal", "operator", "runner"]).passwords.items() > (
        first.passwords.items()
    )
    assert len({*first.passwords.values()}) == 2
    assert min(map(len, first.passwords.values())) == 64
    assert folder.stat().st_mode & 0o777 == 0o700
    assert (folder / PASSWORDS).stat().st_mode & 0o777 == 0o600
    assert first.passwords["hal"] not in repr(load_deployment(FILE).endpoints("hal"))


@pytest.mark.parametrize("wide", [PASSWORDS, "."])
def test_what_others_could_have_read_is_refused(folder: Path, wide: str) -> None:
    find_secrets(KEYS, ["hal"])
    (folder / wide).chmod(0o755)
    with pytest.raises(ConfigError, match=r"expected mode [67]00 of this user .* got 755"):
        find_secrets(KEYS, ["hal"])


@pytest.mark.parametrize("text", [b"hal\n", b"hal:short\n", b"hal:\n", b"\n", b"\xff" * 40])
def test_a_file_that_is_none_of_ours_is_refused(folder: Path, text: bytes) -> None:
    find_secrets(KEYS, ["hal"])
    (folder / PASSWORDS).write_bytes(text)
    with pytest.raises(ConfigError, match="expected lines name:password"):
        find_secrets(KEYS, ["hal"])


def test_a_pipe_in_their_place_is_named_and_keeps_nobody_waiting(folder: Path) -> None:
    folder.mkdir(parents=True, mode=0o700)
    os.mkfifo(folder / PASSWORDS, 0o600)
    with pytest.raises(ConfigError, match=rf"{PASSWORDS}: cannot be read or made: a pipe or a"):
        find_secrets(KEYS, ["hal"])


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "access").write_text("")
    with pytest.raises(ConfigError, match=f"{ACCESS_VARIABLE} names another folder"):
        find_secrets(KEYS, ["hal"])


def test_a_state_folder_that_cannot_be_made_is_named_by_its_own_variable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.delenv(ACCESS_VARIABLE, raising=False)
    monkeypatch.setenv(STATE_VARIABLE, str(tmp_path / "file"))
    with pytest.raises(ConfigError, match=f"{STATE_VARIABLE} names another folder"):
        find_secrets(KEYS, ["hal"])


@pytest.mark.processes
def test_another_user_cannot_read_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """A link needs a password, so whoever cannot read it is a stranger (`test_matrix`)."""
    setpriv = shutil.which("setpriv") or pytest.skip("no setpriv")
    as_nobody = [setpriv, "--reuid=65534", "--regid=65534", "--clear-groups"]
    if subprocess.run([*as_nobody, "true"], capture_output=True, check=False).returncode:
        pytest.skip("only root can become another user")
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)
        (Path(name) / "beside").write_text("for all")
        monkeypatch.setenv(ACCESS_VARIABLE, name)
        file = find_secrets(KEYS, ["hal"]).file
        for path, is_read in ((Path(name) / "beside", True), (file, False)):
            words = [*as_nobody, "cat", str(path)]
            done = subprocess.run(words, capture_output=True, text=True, check=False)
            assert (done.returncode == 0) == is_read
        assert "Permission denied" in done.stderr
