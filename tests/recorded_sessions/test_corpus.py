"""The recorded sessions: small, whole, and named; and how they are read and chosen."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bench.recorded_sessions.__main__ import CORPUS, MOST_BYTES
from bench.recorded_sessions.choice import choose
from bench.recorded_sessions.decision_log import (
    BOOT,
    END,
    TIMER,
    LogRecord,
    config_text,
    read_log,
    write_log,
)
from bench.recorded_sessions.session import Session, read_session

LOGS = [CORPUS / f"{robot}.decisions" for robot in MOST_BYTES]


@pytest.mark.parametrize("log", LOGS, ids=lambda log: log.stem)
def test_recorded_sessions_take_no_more_room_than_they_may(log: Path) -> None:
    header = 50_000  # the gate file, as recorded
    assert log.stat().st_size < MOST_BYTES[log.stem] + header


@pytest.mark.parametrize("log", LOGS, ids=lambda log: log.stem)
def test_a_corpus_is_one_log_of_its_robot_with_a_name_for_each_session(log: Path) -> None:
    records = read_log(log)
    assert records[-1].type == END
    assert json.loads(config_text(records))["robot"] == log.stem
    sessions = sum(record.type == BOOT for record in records)
    assert sessions == len(log.with_suffix(".sessions").read_text("utf-8").splitlines())


def test_a_log_ends_where_a_byte_is_not_what_was_written(tmp_path: Path) -> None:
    whole = [LogRecord(TIMER, bytes([n] * 12)) for n in range(4)]
    path = tmp_path / "made.decisions"
    write_log(path, whole)
    assert read_log(path) == whole
    data = bytearray(path.read_bytes())
    data[-(21 + 9)] ^= 1  # within the last but one
    path.write_bytes(data)
    assert read_log(path) == whole[:2]


def test_a_day_is_cut_at_its_size_and_begins_with_a_boot(tmp_path: Path) -> None:
    path = tmp_path / "made.decisions"
    timer = LogRecord(TIMER, bytes(12))  # 21 bytes in the file
    boot = LogRecord(BOOT, bytes(17))
    write_log(path, [LogRecord(1, b"{}"), boot, timer, timer, timer])
    session = read_session(path, "made", "", 26 + 42)
    assert session is not None and session.records == (boot, timer, timer)
    write_log(path, [LogRecord(1, b"{}"), timer])
    assert read_session(path, "made", "", 1000) is None


def a_session(name: str, size: int, *shows: str) -> Session:
    return Session(name, "", (LogRecord(TIMER, bytes(size - 9)),), frozenset(shows))


def test_chosen_is_what_shows_most_for_its_bytes_and_nothing_beyond_the_room() -> None:
    large = a_session("large", 1000, "a", "b", "c")
    small = a_session("small", 100, "a", "b")
    other = a_session("other", 300, "c")
    again = a_session("again", 100, "a")
    assert choose([large, small, other, again], [], 450) == [small, other]
    assert choose([large, small, other, again], [again], 550) == [again, small, other]
    assert choose([large], [], 999) == []
