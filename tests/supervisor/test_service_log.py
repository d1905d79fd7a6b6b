"""The files of services' lines, without a service."""

from __future__ import annotations

from pathlib import Path

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
