"""Every name that is defined is used somewhere: by the product, an example or a test."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from tests.repo.tree import ROOT, python_files, tree

CODE = ("shared/", "services/", "bench/")
# Called by name from outside: by the framework that the decorator hands them to.
HANDED_ON = re.compile(r"validator|serializer|command|callback|register")
USED_ELSEWHERE = {
    "reward",  # robosuite asks every environment for it
    "list_commands",  # typer asks a group for it
    "emit",  # logging hands a handler each record by it
}


def definitions() -> Iterator[tuple[str, str]]:
    """Name and place of every function, class, method and module-level name."""
    for path in python_files(*CODE):
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                handed_on = any(HANDED_ON.search(ast.unparse(d)) for d in node.decorator_list)
                if not handed_on and not node.name.startswith("__"):
                    yield node.name, f"{path}:{node.lineno}"
        for statement in tree(path).body:
            if isinstance(statement, ast.Assign | ast.AnnAssign):
                targets = statement.targets if isinstance(statement, ast.Assign) else []
                for target in targets or [statement.target]:  # type: ignore[union-attr]
                    if isinstance(target, ast.Name) and not target.id.startswith("__"):
                        yield target.id, f"{path}:{statement.lineno}"


def uses() -> Iterator[str]:
    """Every name that is read, also as an attribute or in a short string (a table of names)."""
    for path in python_files(*CODE, "docs/", "tests/"):
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                yield node.id
            elif isinstance(node, ast.Attribute):
                yield node.attr
            elif isinstance(node, ast.Constant) and " " not in str(node.value):
                yield from re.findall(r"\w+", str(node.value))


def test_nothing_is_defined_that_nobody_uses() -> None:
    used = {*uses(), *USED_ELSEWHERE}
    # What a package registers in pyproject.toml is found by its name there.
    used |= set(re.findall(r"\w+", (ROOT / "pyproject.toml").read_text()))
    dead = {f"{place} {name}" for name, place in definitions() if name not in used}
    assert dead == set()
