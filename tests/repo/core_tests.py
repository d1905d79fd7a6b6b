"""Which codes the gate's core has, which it asks, and which C++ tests are about each."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from fairlead.paths import repo_root

SAFETY = repo_root() / "services" / "safety"
CORE = SAFETY / "src" / "core"
EVIDENCE = CORE / "chunk" / "judgement.hpp"
CASE = re.compile(r'^TEST_CASE\(\s*"([^"]+)"', re.M)
CODE_IN_NAME = re.compile(r"\bG(\d{3})\b")
SWEEP = re.compile(r"just_above|just_below|[+-] 1e-|[+-] eps\b")


@dataclass(frozen=True)
class CoreTest:
    """One test case: its file's name, its own, and whether it comes close to a limit."""

    file: str
    name: str
    sweeps: bool

    @property
    def codes(self) -> set[int]:
        """The codes that its name says, 24 for G024."""
        return {int(code) for code in CODE_IN_NAME.findall(self.name)}


def declared_codes() -> dict[str, int]:
    """The names in ``namespace code``, with their numbers."""
    block = re.search(r"namespace code \{(.*?)\}", EVIDENCE.read_text(), re.S)
    assert block is not None, f"no namespace code in {EVIDENCE}"
    return {name: int(number) for name, number in re.findall(r"(\w+) = (\d+)", block.group(1))}


def asked_codes() -> set[int]:
    """Those that some check of the core gives as its evidence."""
    text = "\n".join(path.read_text() for path in sorted(CORE.rglob("*.cpp")))
    text += "\n".join(path.read_text() for path in CORE.rglob("*.hpp") if path != EVIDENCE)
    used = set(re.findall(r"code::(\w+)", text))
    return {number for name, number in declared_codes().items() if name in used}


def core_tests() -> list[CoreTest]:
    """Every C++ test case whose name says a code."""
    found = []
    for path in sorted((SAFETY / "test").rglob("*.cpp")):
        found += [test for test in _tests_in(path) if test.codes]
    return found


def _tests_in(path: Path) -> list[CoreTest]:
    text = path.read_text()
    starts = list(CASE.finditer(text))
    ends = [*[match.start() for match in starts][1:], len(text)]
    return [
        CoreTest(path.name, match.group(1), SWEEP.search(text, match.start(), end) is not None)
        for match, end in zip(starts, ends, strict=False)
    ]
