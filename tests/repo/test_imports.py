"""Who may import whom: the rules of docs/design.md as tests."""

from __future__ import annotations

import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.repo.tree import files, imports, python_files, text_of

SERVICES = ("hal_mujoco", "hal_sim", "safety", "skill_runner", "state_assembler")
TOOLS = "shared/fairlead_tools/"
DRAWING = ("imageio", "imageio_ffmpeg", "matplotlib")
HAL = "shared/fairlead/hal/"
RUNNER = "services/skill_runner/fairlead_skill_runner/"
ASSEMBLER = "services/state_assembler/fairlead_state_assembler/"
SIMULATOR = "services/hal_sim/fairlead_hal_sim/"
# The folders of the shared package, and which of each other they may import.
_TABLE = text_of(Path("docs/design.md")).partition("### Inside shared")[2]
LAYERS = {
    name: set(re.findall(r"\w+", below))
    for name, below in re.findall(r"^\| `(\w+)/` \| .* \| (.*?) ?\|$", _TABLE, re.M)
}
# What decides, and what it decides with: functions of what they are given, time included.
PURE = (
    *(f"{HAL}{name}.py" for name in ("core", "claim_rows", "claim_table", "lease_follower")),
    *(f"{HAL}{name}.py" for name in ("stop_register", "released_chunk", "period_clock", "episode")),
    *(f"{RUNNER}{name}.py" for name in ("run_core", "chunk_book", "candidate")),
    "shared/fairlead/operate/claim_watch.py",
    *(f"{RUNNER}{name}.py" for name in ("intake", "observation_schedule", "dispatch", "results")),
    *(f"{ASSEMBLER}{name}.py" for name in ("core", "transform_buffer", "registry", "pose_vector")),
    "shared/fairlead/layouts/",
    *(f"{SIMULATOR}{name}.py" for name in ("packing", "base_frame")),
    "shared/fairlead/messages/",
)
IMPURE = {
    *("asyncio", "datetime", "multiprocessing", "os", "pathlib", "queue", "random", "secrets"),
    *("socket", "subprocess", "threading", "time", "zenoh"),
    *("fairlead.service", "fairlead.wire.session"),
}


def service_of(module: str) -> str:
    """The service a module belongs to, "" if none; to no service belong the tools."""
    head = module.split(".")[0]
    if head == "fairlead_tools":
        return ""
    return head.removeprefix("fairlead_") if head.startswith("fairlead_") else ""


def importers(package: str) -> set[str]:
    """Files of the product that import a package from outside."""
    return {
        str(path)
        for path in python_files("shared/", "services/")
        if any(module.split(".")[0] == package for module in imports(path))
    }


def test_the_services_are_the_known_ones_and_any_number_of_hals() -> None:
    others = {name for name in SERVICES if not name.startswith("hal_")}
    assert others == {"safety", "skill_runner", "state_assembler"}
    assert {path.parts[1] for path in files() if path.parts[0] == "services"} == set(SERVICES)


@pytest.mark.parametrize("service", SERVICES)
def test_no_service_imports_another(service: str) -> None:
    foreign = {
        f"{path}: {module}"
        for path in python_files(f"services/{service}/")
        for module in imports(path)
        if service_of(module) not in ("", service)
    }
    assert foreign == set()


def test_the_shared_package_imports_no_service() -> None:
    wrong = {
        f"{path}: {module}"
        for path in python_files("shared/fairlead/")
        for module in imports(path)
        if service_of(module)
    }
    assert wrong == set()


def test_nothing_below_the_tools_imports_a_tool() -> None:
    wrong = {
        f"{path}: {module}"
        for path in python_files("shared/fairlead/", "services/")
        for module in imports(path)
        if module.startswith("fairlead_tools")
    }
    assert wrong == set()


def test_the_topics_of_the_messages_are_imported_through_their_face() -> None:
    inside = {
        f"{path}: {module}"
        for path in python_files("shared/", "services/", "bench/", "tests/", "docs/")
        for module in imports(path)
        if module.startswith("fairlead.messages.") and "messages" not in path.parts
    }
    assert inside == set()


def test_no_modules_of_the_shared_package_import_each_other_in_a_circle() -> None:
    graph = {}
    for path in python_files("shared/"):
        if path.name != "__init__.py":
            module = ".".join(path.with_suffix("").parts[1:])
            graph[module] = {one for one in imports(path) if one.startswith("fairlead")}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_no_module_of_tests_is_imported_by_another() -> None:
    """What tests share is in a file that is named after it."""
    found = {
        f"{path}: {module}"
        for path in python_files("tests/", "bench/")
        for module in imports(path)
        if module.rpartition(".")[2].startswith(("test_", "conftest"))
    }
    assert found == set()


def test_the_document_of_the_shared_package_names_its_folders() -> None:
    folders = {path.parts[2] for path in python_files("shared/fairlead/") if len(path.parts) > 3}
    assert folders == {*LAYERS}


@pytest.mark.parametrize("folder", LAYERS)
def test_a_folder_of_the_shared_package_imports_only_those_below_it(folder: str) -> None:
    imported = {
        one.split(".")[1]
        for path in python_files(f"shared/fairlead/{folder}/")
        for one in imports(path)
        if one.startswith("fairlead.")
    }
    assert imported & {*LAYERS} - {folder} - LAYERS[folder] == set()


def test_zenoh_is_imported_in_one_file() -> None:
    assert importers("zenoh") == {"shared/fairlead/wire/session.py"}


@pytest.mark.parametrize("simulator", ["mujoco", "robosuite"])
def test_simulators_are_imported_by_hals_and_tools_only(simulator: str) -> None:
    # Where a model has its frames is asked by the simulated HALs and by the robot's shape: once.
    shared = (f"{HAL}mujoco_frames.py",) if simulator == "mujoco" else ()
    allowed = ("services/hal_", *shared, TOOLS)
    assert {path for path in importers(simulator) if not path.startswith(allowed)} == set()


def test_poses_are_computed_in_the_assembler_only() -> None:
    assert {path for path in importers("pinocchio") if not path.startswith(ASSEMBLER)} == set()


@pytest.mark.parametrize("package", DRAWING)
def test_pictures_are_drawn_in_one_folder_only(package: str) -> None:
    folder = "shared/fairlead_tools/record/"
    assert {path for path in importers(package) if not path.startswith(folder)} == set()


@pytest.mark.parametrize("name", PURE)
def test_what_decides_has_no_clock_no_thread_and_no_file(name: str) -> None:
    paths = python_files(name)
    assert paths, f"{name} is gone"
    impure = {f"{path}: {module}" for path in paths for module in imports(path) & IMPURE}
    assert impure == set()


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
