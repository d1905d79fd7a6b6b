"""`fairlead acl show`, and what says that access is open."""

from __future__ import annotations

import json
from pathlib import Path

import yaml

from fairlead.paths import repo_root
from tests.cli.command import fairlead_here

FILE = repo_root() / "compose" / "panda_mujoco.yaml"


def opened(folder: Path) -> Path:
    file = folder / "open.yaml"
    content = yaml.safe_load(FILE.read_text(encoding="utf-8")) | {"access": "open"}
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return file


def test_the_table_has_a_line_for_each_key_and_kind(tmp_path: Path) -> None:
    done = fairlead_here("acl", "show", "panda_mujoco", state=tmp_path)
    assert done.returncode == 0
    lines = [line.split() for line in done.stdout.splitlines()]
    assert ["fl/panda/safety/lease", "published", "safety"] in [line[:3] for line in lines]
    assert "WARNING" not in done.stdout


def test_as_data_it_says_who_may_write_and_read(tmp_path: Path) -> None:
    done = fairlead_here("acl", "show", "panda_mujoco", "--json", state=tmp_path)
    document = json.loads(done.stdout)
    assert document["access"] == "closed"
    goal = {"key": "fl/panda/skill/runner/goal", "except": [], "kind": "query"}
    assert goal | {"write": ["operator"], "read": ["runner"]} in document["rows"]


def test_the_operator_may_not_do_what_is_a_runners_own(tmp_path: Path) -> None:
    key, but = "fl/panda/action/candidate/*", "fl/panda/action/candidate/runner"
    text = fairlead_here("acl", "show", "panda_mujoco", state=tmp_path).stdout
    [line] = [one.split() for one in text.splitlines() if one.startswith(key)]
    assert (line[2], line[-1]) == ("operator", but)
    data = fairlead_here("acl", "show", "panda_mujoco", "--json", state=tmp_path).stdout
    [row] = [one for one in json.loads(data)["rows"] if one["key"] == key]
    assert (row["write"], row["except"]) == (["operator"], [but])


def test_of_an_open_deployment_it_says_that_nothing_enforces_it(tmp_path: Path) -> None:
    done = fairlead_here("acl", "show", str(opened(tmp_path)), state=tmp_path)
    why = "access is open, as its file says: whoever reaches a service may move the robot"
    assert f"WARNING nothing enforces this: {why}" in done.stdout
