"""Credentials and the list of what runs, where the disk takes nothing or has a bad file."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fairlead.deploy.credentials import access_dir, find_secrets, write_session
from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead.keys import Keys
from fairlead.paths import ACCESS_VARIABLE

KEYS = Keys("kept")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    before = os.umask(0o022)
    monkeypatch.setenv(ACCESS_VARIABLE, str(tmp_path / "state" / "access"))
    find_secrets(KEYS, ["hal", "safety"])
    write_session(KEYS, "safety", {"a": 1})
    yield access_dir(KEYS)
    os.umask(before)


def fails(*_: Any, **__: Any) -> None:
    raise OSError(errno.EROFS, "Read-only file system", "here")


def test_whoever_has_a_password_needs_no_disk_that_takes_anything(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = find_secrets(KEYS, ["hal"])
    with monkeypatch.context() as patch:
        patch.setattr(fcntl, "flock", fails)
        patch.setattr(os, "open", fails)
        patch.setattr(Path, "mkdir", fails)
        assert find_secrets(KEYS, ["hal", "safety"]).passwords == before.passwords


def test_what_a_session_needs_is_not_written_again(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(os, "open", fails)
        assert write_session(KEYS, "safety", {"a": 1}).read_text() == '{"a": 1}'
        with pytest.raises(OSError, match="Read-only"):
            write_session(KEYS, "safety", {"a": 2})


def test_all_of_it_is_this_users_alone(folder: Path) -> None:
    for path in (folder.parent, *folder.parent.rglob("*")):
        if path.name != "lock":  # in a folder that nobody else may look into
            assert path.stat().st_mode & 0o077 == 0, path


def test_one_bad_file_hides_no_robot_that_runs(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    registry = Registry(tmp_path)
    own = ServiceEntry(process_id(os.getpid()), True, 0)
    registry.write(Running("mine", "/mine.yaml", "/state", None, {"safety": own}))
    (tmp_path / "running" / "bad.json").write_bytes(b"")
    assert [entry.name for entry in registry.entries()] == ["mine"]
    assert "bad.json cannot be read" in caplog.text
    registry.lock("other").close()
