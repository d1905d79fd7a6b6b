"""tests/records/README.md, made of the names and sentences of the tests in tests/records."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from pathlib import Path

from fairlead.paths import repo_root

TESTS = repo_root() / "tests" / "records"
PAGE = TESTS / "README.md"
RECORDS = {
    "state": "The state vector that a policy was trained on",
    "action": "The action vector that a policy emits",
}
INTRODUCTION = """# The two decisions fairlead began with

One sentence for each test in `tests/records`; `scripts/test tests/records -k state_20` runs
one. Written by `python -m bench.pages --write`."""
_NAME = re.compile(r"test_(state|action)_(\d\d)_(\w+)")


@dataclass(frozen=True)
class Sentence:
    """One promise: which record, its number there, and its words."""

    record: str
    number: int
    words: str


def sentences() -> list[Sentence]:
    """Every sentence that a test there holds, by record and number.

    Raises:
        ValueError: for a test without a number, or a record whose numbers have a gap.
    """
    found = [one for path in sorted(TESTS.glob("test_*.py")) for one in _of(path)]
    found.sort(key=lambda one: (list(RECORDS).index(one.record), one.number))
    for record in RECORDS:
        numbers = [one.number for one in found if one.record == record]
        if numbers != list(range(1, len(numbers) + 1)):
            raise ValueError(f"records: numbers of {record} have a gap or repeat: {numbers}")
    return found


def _of(path: Path) -> list[Sentence]:
    read = []
    for node in ast.parse(path.read_text()).body:
        if not isinstance(node, ast.FunctionDef) or not node.name.startswith("test_"):
            continue
        name, words = _NAME.fullmatch(node.name), ast.get_docstring(node)
        if name is None or words is None:
            raise ValueError(f"records: {path.name}: {node.name} lacks a number or a sentence")
        read.append(Sentence(name[1], int(name[2]), words.replace("\n", " ")))
    return read


def listed(record: str) -> str:
    """One record's sentences in Markdown."""
    return "\n".join(f"{one.number}. {one.words}" for one in sentences() if one.record == record)


def current_page() -> str:
    """The page as it has to be now."""
    parts = [INTRODUCTION, *(f"## {title}\n\n{listed(name)}" for name, title in RECORDS.items())]
    return "\n\n".join(parts) + "\n"
