"""The lock files fit pyproject.toml, are complete with hashes, and name no registry."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import version

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.repo.tree import ROOT

LOCK = (ROOT / "requirements.lock").read_text()
RUN_LOCK = (ROOT / "requirements-run.lock").read_text()
LOCKS = [
    "requirements.lock", "requirements-run.lock", "tests/peers/requirements.lock",
    "scripts/audit.lock", "scripts/uv.lock",
]  # fmt: skip
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
UNLOCKED = "train-pictures"
"""The one extra that no lock has: jax is 400 MB."""
EXTRAS = PROJECT["project"]["optional-dependencies"]
WANTED = [
    *PROJECT["project"]["dependencies"],
    *(one for name, extra in EXTRAS.items() if name != UNLOCKED for one in extra),
    *(one for group in PROJECT["dependency-groups"].values() for one in group),
]


def locked(lock: str = LOCK) -> dict[str, list[str]]:
    """Versions by package: more than one where they differ by Python version."""
    pins: dict[str, list[str]] = {}
    for name, pin in re.findall(r"^([a-z0-9-]+)==(\S+)", lock, re.M):
        pins.setdefault(name, []).append(pin)
    return pins


@pytest.mark.parametrize("text", WANTED)
def test_a_dependency_is_locked_at_a_version_it_allows(text: str) -> None:
    wanted = Requirement(text)
    pins = locked().get(canonicalize_name(wanted.name), [])
    assert pins, "run scripts/lock"
    assert all(pin in wanted.specifier for pin in pins), "run scripts/lock"
    assert version(wanted.name) in pins, "run scripts/setup"


def test_what_a_wheel_is_installed_with_is_the_part_of_the_lock_that_runs_it() -> None:
    groups = PROJECT["dependency-groups"]
    wanted = [*PROJECT["project"]["dependencies"], *groups["simulator"]]
    names = {canonicalize_name(Requirement(one).name) for one in wanted}
    run, everything = locked(RUN_LOCK), locked()
    assert names <= set(run), "run scripts/lock"
    assert run == {name: everything[name] for name in run}, "run scripts/lock"
    assert not {"ruff", "mypy", "hatchling"} & set(run)


@pytest.mark.parametrize("path", LOCKS)
def test_every_locked_package_has_hashes(path: str) -> None:
    blocks = re.split(r"\n(?=\S)", (ROOT / path).read_text())
    pinned = [block for block in blocks if "==" in block]
    assert pinned and [b.split(" ")[0] for b in pinned if "--hash=sha256:" not in b] == []


@pytest.mark.parametrize("path", LOCKS)
def test_the_lock_file_names_no_registry(path: str) -> None:
    assert re.findall(r"https?:|index-url|find-links", (ROOT / path).read_text()) == []


@pytest.mark.parametrize("path", [path for path in LOCKS if path != "requirements-run.lock"])
def test_each_lock_is_asked_about_advisories(path: str) -> None:
    """But for the part of another."""
    assert path in re.split(r"[\s;]+", (ROOT / "scripts/audit").read_text())


@pytest.mark.parametrize("path", ["scripts/audit", "scripts/peers", "scripts/setup", "scripts/uv"])
def test_a_script_installs_nothing_from_a_registry_without_hashes(path: str) -> None:
    text = (ROOT / path).read_text().replace("\\\n", " ")
    installs = re.findall(r"^.*pip (?:install|sync) .*$", text, re.M)
    assert installs
    assert [one for one in installs if not re.search("--require-hashes|--no-deps", one)] == []
