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
# Of a finding, as the last argument of a `check` of one, or in the cause of a stop.
UNIT = re.compile(
    r'(?:unit == "|, \d+,\s*"|, limit [-\d.e]+ )'
    r'(N m|N|rad/s|rad|m/s|ms|m|us|ticks|rows|1)(?="\);|[ "])'
)
SWEEP = re.compile(r"just_above|just_below|[+-] 1e-|[+-] eps\b")


@dataclass(frozen=True)
class CoreTest:
    """One test case: its file's name, its own, whether it comes close to a limit, and
    which units of magnitudes it asks for."""

    file: str
    name: str
    sweeps: bool
    units: frozenset[str]

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


@dataclass(frozen=True)
class CoreRule:
    """A rule without a magnitude: of which code, and what it needs."""

    code: int
    words: str


def core_rules() -> list[CoreRule]:
    """Every rule that the core has a literal for."""
    found = []
    for path in sorted(CORE.rglob("*.cpp")):
        text = path.read_text()
        named = dict(re.findall(r'constexpr std::string_view (\w+) =\s*"([^"]+)"', text))
        for call in re.findall(r"broken_rule\(([^;]*);", text):
            literals = re.findall(r'"([^"]+)"', re.sub(r'"\s+"', "", call))
            said = [
                *literals[-1:],
                *(named[word] for word in re.findall(r"\w+", call) if word in named),
            ]
            name = re.match(r"code::(\w+)", call)  # none: what G021 to G023 have in common
            codes = [declared_codes()[name[1]]] if name else [21, 22, 23]
            found += [CoreRule(code, said[-1]) for code in codes if "made_of" not in call]
    return found


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
        CoreTest(
            path.name,
            match.group(1),
            SWEEP.search(text, match.start(), end) is not None,
            frozenset(UNIT.findall(text, match.start(), end)),
        )
        for match, end in zip(starts, ends, strict=False)
    ]
