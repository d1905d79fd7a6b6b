"""What may stand where, and who may import whom: the rules of docs/design.md as tests."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.repo.tree import ROOT, files, imports, python_files, text_of, tree

TOP_LEVEL = {
    ".ci",
    ".clang-format",
    ".gitignore",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "LICENSE",
    "Makefile",
    "README.md",
    "bench",
    "compose",
    "docs",
    "pyproject.toml",
    "requirements-run.lock",
    "requirements.lock",
    "robots",
    "rskills",
    "scripts",
    "services",
    "shared",
    "tests",
}
# The tools that run every service, or a whole episode in one process.
TOOLS = ("cli", "demo", "parity")
SERVICES = ("hal_mujoco", "hal_sim", "safety", "skill_runner", "state_assembler")
NAMELESS = {"utils", "util", "helpers", "helper", "common", "manager", "base", "misc"}
MAX_LINES = 400
MAX_FUNCTION_LINES = 60


def service_of(module: str) -> str:
    """The service a module belongs to, "" if none."""
    head = module.split(".")[0]
    return head.removeprefix("fairlead_") if head.startswith("fairlead_") else ""


def test_the_top_level_is_the_fixed_one() -> None:
    assert {path.parts[0] for path in files()} == TOP_LEVEL


def test_the_services_are_the_known_ones_and_any_number_of_hals() -> None:
    others = {name for name in SERVICES if not name.startswith("hal_")}
    assert others == {"safety", "skill_runner", "state_assembler"}
    assert "hal_sim" in SERVICES


def test_robots_and_skills_are_data_only() -> None:
    code = [
        p for p in files() if p.parts[0] in ("robots", "rskills") and p.suffix in (".py", ".sh")
    ]
    assert code == []


@pytest.mark.parametrize("service", SERVICES)
def test_no_service_imports_another(service: str) -> None:
    foreign = {
        f"{path}: {module}"
        for path in python_files(f"services/{service}/")
        for module in imports(path)
        if service_of(module) not in ("", service)
    }
    assert foreign == set()


def test_only_the_tools_of_the_shared_package_import_services() -> None:
    wrong = {
        f"{path}: {module}"
        for path in python_files("shared/")
        for module in imports(path)
        if service_of(module) and path.parts[2] not in TOOLS
    }
    assert wrong == set()


def test_zenoh_is_imported_in_one_file() -> None:
    importers = {
        str(path)
        for path in python_files("shared/", "services/")
        if any(module.split(".")[0] == "zenoh" for module in imports(path))
    }
    assert importers == {"shared/fairlead/session.py"}


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
        if str(path).startswith(("services/safety/src/core/", "services/safety/include/"))
    ]
    assert core
    assert {str(p): found for p in core if (found := forbidden.findall(text_of(p)))} == {}


@pytest.mark.parametrize(
    "statement",
    [
        "import fairlead.messages, fairlead.keys, fairlead.errors, fairlead.memory_bus",
        "from fairlead_state_assembler import LAYOUT_ASSEMBLERS, assemble_state",
    ],
)
def test_a_notebook_can_import_it_without_zenoh(statement: str) -> None:
    code = f"{statement}; import sys; sys.exit('zenoh' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr.decode()


def test_no_file_has_a_name_that_says_nothing() -> None:
    assert [str(p) for p in files() if p.stem in NAMELESS] == []


def test_no_file_of_code_is_too_long_to_read() -> None:
    long = {
        str(path): lines
        for path in files()
        if path.suffix in (".py", ".cpp", ".hpp", ".rs")
        and "golden" not in path.parts
        and (lines := text_of(path).count("\n")) > MAX_LINES
    }
    assert long == {}


def test_no_function_is_too_long_to_read() -> None:
    long = {
        f"{path}:{node.lineno} {node.name}"
        for path in python_files("shared/", "services/", "bench/", "tests/")
        for node in ast.walk(tree(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and (node.end_lineno or 0) - node.lineno > MAX_FUNCTION_LINES
    }
    assert long == set()


def test_no_test_sleeps_but_in_a_loop_that_waits_for_something() -> None:
    sleepers = [
        f"{path}:{call.lineno}"
        for path in python_files("tests/")
        for call in sleeps(tree(path), in_loop=False)
    ]
    assert sleepers == []


def sleeps(node: ast.AST, in_loop: bool) -> Iterator[ast.Call]:
    """Calls of ``sleep`` that no ``while`` loop surrounds."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Call) and ast.unparse(child.func).endswith("sleep"):
            if not in_loop:
                yield child
        else:
            yield from sleeps(child, in_loop or isinstance(child, ast.While))


def test_nothing_is_left_to_do_in_the_code() -> None:
    marks = re.compile(r"\b(TODO|FIXME|XXX|NotImplementedError)\b")
    here = Path("tests/repo/test_structure.py")
    assert [
        str(p)
        for p in files()
        if p.suffix in (".py", ".cpp", ".hpp", ".rs", ".md")
        and p != here
        and marks.search(text_of(p))
    ] == []


def test_no_file_names_a_place_outside_the_repository() -> None:
    places = re.compile(r"\.\./shared\b|/work/|pypi\.org|pythonhosted|npmjs|/root/|/home/\w")
    here = Path("tests/repo/test_structure.py")
    found = {str(p): places.findall(text_of(p)) for p in files() if p != here}
    assert {name: hits for name, hits in found.items() if hits} == {}


def test_links_between_documents_lead_somewhere() -> None:
    broken = []
    for path in files():
        if path.suffix == ".md":
            for target in re.findall(r"\]\(([^)#:]+?)(?:#[^)]*)?\)", text_of(path)):
                if not (ROOT / path.parent / target).exists():
                    broken.append(f"{path} -> {target}")
    assert broken == []


def test_every_script_is_executable_and_explains_itself() -> None:
    for path in files():
        text = text_of(path)
        if path.parts[0] in ("scripts", ".ci") and text.startswith("#!"):
            assert (ROOT / path).stat().st_mode & 0o100, f"{path} is not executable"
            assert text.splitlines()[1].startswith(("# ", '"""')), (
                f"{path} does not say what it does"
            )


def test_make_offers_only_what_its_help_lists() -> None:
    makefile = (ROOT / "Makefile").read_text()
    phony = re.search(r"^\.PHONY: (.*)$", makefile, re.M)
    assert phony
    described = re.findall(r"^([a-z]+):.*## ", makefile, re.M)
    assert sorted(phony.group(1).split()) == sorted(described)
