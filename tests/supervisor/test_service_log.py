"""The files of services' lines, without a service."""

from __future__ import annotations

from pathlib import Path

from fairlead.supervisor.service_log import ServiceLog


def test_a_full_log_is_set_aside_and_the_newest_two_files_are_kept(tmp_path: Path) -> None:
    log = ServiceLog(tmp_path / "safety.log", most_bytes=40)
    for number in range(10):
        assert log.append(f"line {number:04}") == ""
    log.close()
    before = (tmp_path / "safety.log.1").read_text().split()[1::2]
    now = (tmp_path / "safety.log").read_text().split()[1::2]
    assert [*before, *now] == [f"{number:04}" for number in range(4, 10)]
    assert len(list(tmp_path.iterdir())) == 2
