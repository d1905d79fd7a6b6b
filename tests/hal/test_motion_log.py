"""The log never delays a tick, whatever the disk does."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from fairlead import line_writer
from fairlead.hal.plan_executor import MotionLog
from fairlead.line_writer import LineWriter
from tests.hal.gate_messages import HELD, executed


def test_a_line_says_tick_session_time_and_what_every_part_did(tmp_path: Path) -> None:
    log = MotionLog(tmp_path, 77, trace=False)
    log.tick(5, 123456, (executed(9, 2), HELD), "overrun", 123400)
    log.close()
    (line,) = (tmp_path / "motion.jsonl").read_text().splitlines()
    assert json.loads(line) == {
        "tick": 5,
        "session": 77,
        "stamp_ns": 123456,
        "acted": [[0, 9, 2], [2, 0, 0]],
        "event": "overrun",
        "lease_ns": 123400,
    }


def test_a_restarted_hal_appends(tmp_path: Path) -> None:
    for session in (1, 2):
        log = MotionLog(tmp_path, session, trace=False)
        log.tick(1, 0, (), None, 0)
        log.close()
    lines = (tmp_path / "motion.jsonl").read_text().splitlines()
    assert [json.loads(line)["session"] for line in lines] == [1, 2]


def test_a_disk_that_hangs_costs_lines_not_ticks_and_the_log_says_so(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "never_read"
    os.mkfifo(path)  # opening it for writing blocks until somebody reads
    writer = LineWriter(path)
    for _ in range(line_writer.MAX_QUEUED + 10):
        writer.put("line")
    assert writer.dropped == 10
    with path.open() as reader:
        writer.put("late")
        reader.readline()
    writer.close(timeout_s=0.5)
    assert caplog.messages[0] == f"{path}: the disk is stuck, lines are lost"
    assert any(message.endswith("lines were lost") for message in caplog.messages[1:])


def test_a_full_file_is_set_aside_and_the_newest_two_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "motion.jsonl"
    path.write_text("from a run before\n")
    writer = LineWriter(path, most_bytes=40)
    for number in range(10):
        writer.put(f"line {number:04}")
    writer.close()
    before = (tmp_path / "motion.jsonl.1").read_text().split("\n")
    now = path.read_text().split("\n")
    assert [*before[:-1], *now[:-1]] == [f"line {n:04}" for n in range(3, 10)]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["motion.jsonl", "motion.jsonl.1"]


def test_a_line_of_any_text_is_written_and_ends_nothing(tmp_path: Path) -> None:
    writer = LineWriter(tmp_path / "trace.jsonl")
    for line in ("before", "größe", "arm\udcff", "after"):
        writer.put(line)
    writer.close()
    written = (tmp_path / "trace.jsonl").read_text(encoding="utf-8")
    assert written == "before\ngröße\narm\\udcff\nafter\n"


def test_whatever_ends_a_recording_is_said_once(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    writer = LineWriter(tmp_path / "trace.jsonl")
    for line in ("before", 5, 6):
        writer.put(f"{line}" if line == "before" else NoText())
    writer.close()
    assert writer.dropped == 1
    path = tmp_path / "trace.jsonl"
    assert caplog.messages == [f"{path}: no longer recorded: TypeError: no text"]


class NoText(str):
    """A line that cannot be formatted."""

    __slots__ = ()

    def __format__(self, spec: str) -> str:
        raise TypeError("no text")
