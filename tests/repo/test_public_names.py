"""The names that others may import: which they are, that they say what they are, what they load."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys

import pytest

import fairlead
from fairlead import errors
from tests.repo.tree import ROOT

# The modules whose names others may import: those that the package's docstring lists.
PUBLIC = re.findall(r"^    (fairlead[\w.]*) {2,}\S", fairlead.__doc__ or "", re.M)
FOR_OUR_TOOLS = ["fairlead_hal_sim", "fairlead_skill_runner"]
HEAVY = ("mujoco", "robosuite", "pinocchio", "zenoh")


def loaded_by(statement: str) -> set[str]:
    """Which of the heavy packages a fresh interpreter has loaded after a statement."""
    code = f"{statement}\nimport sys\nprint(*set(sys.modules) & set({HEAVY!r}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def imported_names(code: str) -> set[tuple[str, str]]:
    """Module and name of everything of this project that a piece of code imports."""
    found = set()
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom):
            found |= {(node.module or "", alias.name) for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {(alias.name, "") for alias in node.names}
    return {(module, name) for module, name in found if module.startswith("fairlead")}


def public_names(module: str) -> list[str]:
    """What others may import of a module; nothing of one that the docstring does not list."""
    return list(importlib.import_module(module).__all__) if module in PUBLIC else []


@pytest.mark.parametrize("module", PUBLIC)
def test_a_public_module_says_what_it_is_and_has_every_name_it_offers(module: str) -> None:
    face, names = importlib.import_module(module), public_names(module)
    assert names and len(names) == len(set(names))
    assert [name for name in names if getattr(face, name, None) is None] == []
    assert face.__doc__


@pytest.mark.simulator
@pytest.mark.parametrize("module", FOR_OUR_TOOLS)
def test_a_service_has_every_name_it_offers_to_the_tools(module: str) -> None:
    face = importlib.import_module(module)
    assert face.__all__
    assert [name for name in face.__all__ if getattr(face, name, None) is None] == []


@pytest.mark.parametrize("module", PUBLIC)
def test_every_public_class_and_function_says_what_it_is(module: str) -> None:
    face = importlib.import_module(module)
    things = {name: getattr(face, name) for name in public_names(module)}
    silent = [
        name
        for name, thing in things.items()
        if getattr(thing, "__module__", "").startswith("fairlead")
        and not (getattr(thing, "__doc__", None) or "").strip()
    ]
    assert silent == []


def test_a_star_imports_every_public_name_of_the_package() -> None:
    names: dict[str, object] = {}
    exec("from fairlead import *", names)  # noqa: S102 - a star is allowed only so
    face = (ROOT / "shared/fairlead/__init__.py").read_text()
    assert names.keys() - {"__builtins__"} == set(re.findall(r" import (\w+) as \1$", face, re.M))
    assert names["load_robot"] is fairlead.load_robot


def test_a_name_the_package_does_not_have_is_missing_as_usual() -> None:
    with pytest.raises(AttributeError, match="^module 'fairlead' has no attribute 'load_robott'$"):
        _ = fairlead.load_robott


@pytest.mark.processes
@pytest.mark.parametrize(
    "statement",
    [
        "import fairlead",
        "from fairlead import ControlMode, Keys, MemoryBus, load_robot, load_skill",
        "import fairlead.errors, fairlead.hal, fairlead.messages",
        "import fairlead_hal_sim, fairlead_skill_runner",
    ],
)
def test_importing_loads_no_simulator_and_no_transport(statement: str) -> None:
    assert loaded_by(statement) == set()


@pytest.mark.processes
def test_talking_to_a_robot_loads_the_transport_and_no_simulator() -> None:
    assert loaded_by("from fairlead import RobotClient; import fairlead.hal.process") == {"zenoh"}


def test_documents_and_examples_import_public_names_only() -> None:
    pieces = {path.name: path.read_text() for path in (ROOT / "docs" / "examples").rglob("*.py")}
    for path in [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]:
        for number, code in enumerate(re.findall(r"```python\n(.*?)```", path.read_text(), re.S)):
            if re.search(r"^(from|import) ", code, re.M):
                pieces[f"{path.name} block {number}"] = code
    used = {
        (where, module, name)
        for where, code in pieces.items()
        for module, name in imported_names(code)
    }
    assert used
    inside = {one for one in used if one[2] not in {"", *public_names(one[1])}}
    assert inside == set()


def test_the_tree_of_errors_is_the_one_that_is_drawn() -> None:
    drawn = re.findall(r"^    [│ ]*[├└]── (\w+)  +\S", errors.__doc__ or "", re.M)
    kinds = [
        one
        for one in vars(errors).values()
        if isinstance(one, type) and one.__module__ == errors.__name__
    ]
    real = [one.__name__ for one in kinds if one is not errors.FairleadError]
    assert drawn == real
    assert {one.__base__ for one in kinds} == {Exception, errors.FairleadError}
