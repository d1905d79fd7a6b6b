"""docs/reading-the-gate.md walks the code: each function is called where the page says."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

import pytest

from bench.gate_size import closure, lines, named_on_the_page
from tests.repo.tree import ROOT

PAGE = (ROOT / "docs/reading-the-gate.md").read_text()
SOURCES = ROOT / "services/safety/src"
STEP = re.compile(r"^( *)(?:([\w/]+\.cpp) )?([\w:]*\w)(?:: .*)?$", re.M)
TREES = "".join(re.findall(r"^```text\n(.*?)^```", PAGE, re.M | re.S))


@dataclass(frozen=True)
class Step:
    """A line of the page: a function in a file, that of the line above if it names none.

    caller: the function that calls it, if any.
    """

    file: str
    function: str
    caller: Step | None

    @property
    def name(self) -> str:
        """Without its class."""
        return self.function.rpartition("::")[2]

    def __str__(self) -> str:
        """As pytest names it."""
        return f"{self.file}:{self.function}"


def steps() -> list[Step]:
    """All of them, from the top of the page."""
    found: list[Step] = []
    above: list[Step] = []
    for indent, file, function in STEP.findall(TREES):
        depth = len(indent) // 2
        assert depth <= len(above), f"{function} is indented under nothing"
        del above[depth:]
        step = Step(file or found[-1].file, function, above[-1] if above else None)
        above.append(step)
        found.append(step)
    return found


STEPS = steps()


@cache
def body_of(file: str, function: str) -> str:
    """What stands between the braces of a function's definitions, "" if it has none there."""
    text = (SOURCES / file).read_text()
    head = rf"^[A-Za-z][^\n;]*?(?<![\w:]){re.escape(function)}\([^;{{}}]*\)[^;{{}}]*\{{\n.*?^\}}$"
    return "\n".join(found[0] for found in re.finditer(head, text, re.M | re.S))


def call_in(body: str, name: str) -> int:
    """Where a body first calls a function, -1 if nowhere."""
    inside = body[body.find("{") :]
    found = re.search(rf"(?<![\w:]){name}\(", inside)
    return found.start() if found else -1


def test_the_page_has_the_way_of_a_chunk_and_of_a_state() -> None:
    assert [step.name for step in STEPS if step.caller is None] == [
        "on_sample",
        "handle",
        "apply",
        "on_joint_state",
    ]


@pytest.mark.parametrize("step", STEPS, ids=str)
def test_each_function_is_defined_where_the_page_says(step: Step) -> None:
    assert (SOURCES / step.file).is_file()
    # `decode` is a template: each message's stands in an instantiation.
    assert body_of(step.file, step.function) or step.name == "decode"


@pytest.mark.parametrize("step", [s for s in STEPS if s.caller], ids=str)
def test_each_function_is_called_by_the_one_it_stands_under(step: Step) -> None:
    assert step.caller
    assert call_in(body_of(step.caller.file, step.caller.function), step.name) >= 0


def test_functions_stand_in_the_order_in_which_they_are_called() -> None:
    for caller in STEPS:
        body = body_of(caller.file, caller.function)
        places = [call_in(body, step.name) for step in STEPS if step.caller is caller]
        assert places == sorted(places), str(caller)


def test_every_check_of_a_chunk_stands_on_the_page_in_the_order_of_its_code() -> None:
    way = PAGE.partition("## The way of a chunk")[2].partition("\nG026")[0]
    judged = way.partition(" Candidates::on_candidate")[2].partition(" judge_rows\n")[0]
    codes = re.findall(r"G\d{3}", judged)
    assert codes == sorted(codes)
    assert codes == [f"G{code:03}" for code in (*range(1, 11), 12)]


def test_the_page_says_how_much_decides_and_no_more_does() -> None:
    """What is taken away need not be written there at once."""
    found = closure(named_on_the_page())
    said = re.search(r"^(\d+) files, (\d+) lines", PAGE, re.M)
    assert said
    assert 0.95 * int(said[1]) <= len(found) <= int(said[1])
    assert 0.95 * int(said[2]) <= lines(found) <= int(said[2])
