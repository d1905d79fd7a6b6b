"""What of the rules of docs/design.md the contracts in pyproject.toml cannot hold."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from tests.repo.tree import ROOT, files, imports, python_files, text_of

CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]


def test_the_contracts_know_every_package() -> None:
    packages = {path.parts[1:3] for path in python_files("services/", "shared/")}
    names = {part for folders in packages for part in folders if part.startswith("fairlead")}
    assert names == set(CONTRACTS["root_packages"])


def test_the_contracts_know_every_folder_of_the_shared_package() -> None:
    (contract,) = [one for one in CONTRACTS["contracts"] if one.get("containers")]
    folders = {path.parts[2] for path in python_files("shared/fairlead/") if len(path.parts) > 3}
    assert {name for layer in contract["layers"] for name in re.findall(r"\w+", layer)} == folders


def test_no_module_of_tests_is_imported_by_another() -> None:
    """What tests share is in a file that is named after it."""
    found = {
        f"{path}: {module}"
        for path in python_files("tests/", "bench/")
        for module in imports(path)
        if module.rpartition(".")[2].startswith(("test_", "conftest"))
    }
    assert found == set()


@pytest.mark.parametrize(
    ("folder", "users"),
    [("bench", ("tests", "bench")), ("tests", ("tests",))],
)
def test_programs_and_tests_are_imported_from_above_only(
    folder: str, users: tuple[str, ...]
) -> None:
    """The product knows neither; programs that a person runs know no test."""
    importers = {
        str(path)
        for path in python_files("")
        if any(module.split(".")[0] == folder for module in imports(path))
    }
    assert importers
    assert {name for name in importers if not name.startswith(users)} == set()


def test_zenoh_is_included_only_in_the_transport_of_the_gate() -> None:
    includers = {
        path.name
        for path in files()
        if path.parts[:2] == ("services", "safety")
        and path.suffix in (".cpp", ".hpp")
        and re.search(r"#include\s*[<\"]zenoh\.h", text_of(path))
        and "tools" not in path.parts  # benchmarks, no part of the gate
    }
    assert includers
    assert {name for name in includers if not name.startswith("zenoh_")} == set()


def test_the_core_of_the_gate_includes_nothing_of_the_shell_around_it() -> None:
    quoted = re.compile(r'^#include "((?!fairlead_safety/|core/)[^"]+)"', re.M)
    core = [path for path in files() if path.is_relative_to(Path("services/safety/src/core"))]
    assert core
    assert {str(p): found for p in core if (found := quoted.findall(text_of(p)))} == {}


def test_the_core_of_the_gate_includes_no_clock_thread_file_or_json() -> None:
    forbidden = re.compile(
        r"#include\s*<(chrono|thread|mutex|fstream|iostream|filesystem|random|nlohmann/.*)>"
    )
    core = [
        path
        for path in files()
        if path.is_relative_to(Path("services/safety/src/core"))
        or path.is_relative_to(Path("services/safety/include"))
    ]
    assert core
    assert {str(p): found for p in core if (found := forbidden.findall(text_of(p)))} == {}
