"""What a service prints without ending its lines: bounded in memory and in the log."""

from __future__ import annotations

import sys

import pytest

from fairlead_tools.supervisor.lines import LONGEST, Lines
from tests.supervisor.bench import Bench, wait_until

PRINTS = (
    f"""exec {sys.executable} -uc 'import time; print({{what}}, end="\\n{{name}}: ready\\n"); """
    "time.sleep(1000)'"
)


@pytest.mark.parametrize(
    ("printed", "lines"),
    [
        ([b"one\ntw", b"o  \n", b"\n"], ["one", "two", ""]),
        ([b"one\r\ntwo\r", b"\nthree\n"], ["one", "two", "three"]),
        ([b"\r 41% done\r 42% d", b"one\nend\n"], [" 42% done", "end"]),
        ([b"41% done\r", b"\r", b"42% done\r\n"], ["42% done"]),
        ([b"a" * 10, b"b" * LONGEST, b"c\n", b"d\n"], [
            "a" * 10 + "b" * (LONGEST - 10) + " ... (cut: 11 bytes more)", "d",
        ]),
        ([b"a" * (LONGEST + 1), b"\rb\n"], ["b"]),
    ],
)  # fmt: skip
def test_lines_are_what_a_terminal_shows_and_no_longer_than_the_bound(
    printed: list[bytes], lines: list[str]
) -> None:
    taker = Lines()
    assert [line for data in printed for line in taker.take(data)] == lines
    assert taker.end() == []


@pytest.mark.parametrize("last", [b"not ended", b"not ended\r", b"before\rnot ended"])
def test_a_last_line_that_is_not_ended_is_kept(last: bytes) -> None:
    taker = Lines()
    assert taker.take(b"first\n" + last) == ["first"]
    assert taker.end() == ["not ended"]


@pytest.mark.asyncio
@pytest.mark.processes
@pytest.mark.parametrize(
    ("what", "ends_with"),
    [
        ('"\\r 42% done" * 2_000_000', " 42% done"),
        ('"x" * 20_000_000', f"x ... (cut: {20_000_000 - LONGEST} bytes more)"),
    ],
)
async def test_much_without_a_newline_is_one_line_of_bounded_length(
    bench: Bench, what: str, ends_with: str
) -> None:
    bench.scripts["runner"] = PRINTS.replace("{what}", what)
    await bench.start()
    await wait_until(lambda: ("runner", "runner: ready") in bench.lines, "it is printed")
    line = next(line for service, line in bench.lines if service == "runner")
    assert line.endswith(ends_with)
    assert len(line) < LONGEST + 100
    log = bench.state_dir / "logs" / "runner.log"
    assert log.stat().st_size < LONGEST + 1000
