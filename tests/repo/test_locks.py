"""Which classes have a lock: those that the design says, and nobody else takes it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from tests.repo.tree import ROOT, python_files, text_of, tree

LOCKS = ("Lock", "RLock", "Condition", "Semaphore", "BoundedSemaphore", "Barrier")


def made() -> Iterator[tuple[str, str]]:
    """Class and attribute of each lock between threads; "" where one is made elsewhere."""
    for path in python_files("shared/", "services/"):
        classes = [one for one in ast.walk(tree(path)) if isinstance(one, ast.ClassDef)]
        within = {id(node): one.name for one in classes for node in ast.walk(one)}
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.Assign) and is_lock(node.value):
                yield within.get(id(node), ""), ast.unparse(node.targets[0])


def is_lock(value: ast.expr) -> bool:
    words = ast.unparse(value).partition("(")[0].split(".")
    return isinstance(value, ast.Call) and words[-1] in LOCKS and words[0] != "asyncio"


def test_the_design_says_what_each_lock_between_threads_guards() -> None:
    section = text_of(ROOT / "docs/design.md").partition("| its lock |")[2].partition("\n\n")[0]
    assert sorted(name for name, _ in made()) == sorted(
        re.findall(r"^\| `(\w+)` \|", section, re.M)
    )


def test_a_lock_is_taken_by_its_own_class_alone() -> None:
    names = {attribute.removeprefix("self.") for _, attribute in made()}
    taken = {
        f"{path}: {ast.unparse(item.context_expr)}"
        for path in python_files("shared/", "services/")
        for node in ast.walk(tree(path))
        if isinstance(node, ast.With)
        for item in node.items
        if isinstance(item.context_expr, ast.Attribute)
        and item.context_expr.attr in names
        and ast.unparse(item.context_expr.value) != "self"
    }
    assert taken == set()
