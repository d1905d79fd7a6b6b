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


@pytest.mark.parametrize("lock", [LOCK, RUN_LOCK], ids=["requirements", "requirements-run"])
def test_every_locked_package_has_hashes(lock: str) -> None:
    blocks = re.split(r"\n(?=\S)", lock)
    bare = [b.split(" ")[0] for b in blocks if "==" in b and "--hash=sha256:" not in b]
    assert bare == []


def test_the_lock_file_names_no_registry() -> None:
    assert re.findall(r"https?:|index-url|find-links", LOCK + RUN_LOCK) == []
