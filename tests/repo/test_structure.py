"""What may stand where, and how long it may be."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from tests.repo.tree import ROOT, files, python_files, text_of, tree

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
NAMELESS = {"utils", "util", "helpers", "helper", "common", "manager", "base", "misc"}
CAMPAIGNS = ("bench/equipment/", "bench/faults/", "bench/soundness/")
MAX_LINES = 300
MAX_BODY_LINES = 40
# Longer files, and why each is better read as one.
LONG_FILES = {
    "shared/fairlead/wire/gate_checks.py": "the table of every check",
    "services/safety/test/core/test_codec.cpp": "every message once, field by field",
    "tests/skill/test_slots.py": "every rule of a slot",
    "tests/system/test_modes.py": "one story for every mode",
}


def test_the_top_level_is_the_fixed_one() -> None:
    assert {path.parts[0] for path in files()} == TOP_LEVEL


def test_robots_and_skills_are_data_only() -> None:
    code = [
        p for p in files() if p.parts[0] in ("robots", "rskills") and p.suffix in (".py", ".sh")
    ]
    assert code == []


def test_no_file_has_a_name_that_says_nothing() -> None:
    assert [str(p) for p in files() if p.stem in NAMELESS] == []


def test_no_file_of_code_is_too_long_to_read_but_those_that_say_why() -> None:
    long = {
        str(path)
        for path in files()
        if path.suffix in (".py", ".cpp", ".hpp", ".rs") and text_of(path).count("\n") > MAX_LINES
    }
    assert long - set(LONG_FILES) == set()
    assert {name for name in LONG_FILES if not (ROOT / name).is_file()} == set()


def test_no_function_is_too_long_to_read() -> None:
    long = {
        f"{path}:{node.lineno} {node.name}"
        for path in python_files("shared/", "services/", "bench/", "tests/")
        for node in ast.walk(tree(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and body_lines(node) > MAX_BODY_LINES
    }
    assert long == set()


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function without its signature and its docstring."""
    body = function.body[1 if ast.get_docstring(function) else 0 :] or function.body
    return (function.end_lineno or 0) - body[0].lineno + 1


def test_no_test_or_campaign_sleeps_but_in_a_loop_that_waits_for_something() -> None:
    sleepers = [
        f"{path}:{call.lineno}"
        for path in python_files("tests/", *CAMPAIGNS)
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
