"""The files of services' lines, without a service."""

from __future__ import annotations

import tracemalloc
from contextlib import closing
from pathlib import Path

import pytest

from fairlead_tools.supervisor.service_log import LogReader, ServiceLog


def test_a_full_log_is_set_aside_and_the_newest_two_files_are_kept(tmp_path: Path) -> None:
    log = ServiceLog(tmp_path / "safety.log", most_bytes=40)
    for number in range(10):
        assert log.append(f"line {number:04}") == ""
    log.close()
    before = (tmp_path / "safety.log.1").read_text().split()[1::2]
    now = (tmp_path / "safety.log").read_text().split()[1::2]
    assert [*before, *now] == [f"{number:04}" for number in range(4, 10)]
    assert len(list(tmp_path.iterdir())) == 2


def test_a_reader_sees_each_line_once_also_those_around_a_full_file(tmp_path: Path) -> None:
    log = ServiceLog(tmp_path / "safety.log", most_bytes=40)
    reader = LogReader(tmp_path / "safety.log")
    assert reader.newest(5) == []
    seen = []
    for number in range(10):
        log.append(f"line {number:04}")
        if number % 3 == 2:
            seen += reader.more()
    assert [*seen, *reader.more()] == [f"line {number:04}" for number in range(10)]
    reader.close()
    log.close()


def test_the_newest_lines_reach_back_into_the_file_that_was_set_aside(tmp_path: Path) -> None:
    log = ServiceLog(tmp_path / "safety.log", most_bytes=40)
    for number in range(6):
        log.append(f"line {number:04}")
    log.close()
    reader = LogReader(tmp_path / "safety.log")
    assert reader.newest(4) == [f"line {number:04}" for number in range(2, 6)]
    reader.close()


def test_no_file_grows_past_its_bound(tmp_path: Path) -> None:
    log = ServiceLog(tmp_path / "safety.log", most_bytes=40)
    for length in (20, 30, 9, 39, 1):
        log.append("x" * length)
        assert all(file.stat().st_size <= 40 for file in tmp_path.iterdir())
    log.close()
    assert (tmp_path / "safety.log.1").read_text() == "x" * 39 + "\n"


@pytest.mark.parametrize("count", [1, 2, 3, 7, 100])
def test_the_newest_lines_are_read_from_the_end_of_a_large_file(tmp_path: Path, count: int) -> None:
    lines = [f"line {number:04} " + "x" * 40_000 for number in range(7)]
    log = ServiceLog(tmp_path / "safety.log")
    for line in lines:
        log.append(line)
    log.close()
    with closing(LogReader(tmp_path / "safety.log")) as reader:
        assert reader.newest(count) == lines[-count:]
        log.append("after")
        assert reader.more() == ["after"]
    log.close()


def test_reading_the_newest_lines_takes_no_memory_for_the_others(tmp_path: Path) -> None:
    with (tmp_path / "safety.log").open("w") as file:
        file.writelines(f"{number:099}\n" for number in range(100_000))
    tracemalloc.start()
    try:
        with closing(LogReader(tmp_path / "safety.log")) as reader:
            assert reader.newest(1) == [f"{99_999:099}"]
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()
