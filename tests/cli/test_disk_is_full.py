"""A disk that takes no more bytes, which Python says without a file: it is named all the same."""

from __future__ import annotations

import resource
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from fairlead.deploy.credentials import write_private
from fairlead.deploy.registry import Registry, Running
from fairlead.paths import repo_root, written
from tests.cli.command import TIMEOUT_S, fairlead_command, fairlead_environment

TWO_HOSTS = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"


def take_little() -> None:
    """Let no file of this process have more than 20 bytes."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (20, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))


def files(folder: Path) -> list[str]:
    return [one.name for one in folder.rglob("*") if one.is_file()]


@pytest.mark.processes
@pytest.mark.parametrize(
    ("command", "file"),
    [
        ("deploy units {file} --host robot --out {folder}", "out/fairlead-panda_mobile."),
        ("deploy containers {file} --host robot --out {folder}", "out/compose.yaml"),
        ("serve-policy panda-joint-reach --host nobody.invalid", "serve-policy: --host"),
    ],
)
def test_what_could_not_be_written_or_reached_is_named(
    command: str, file: str, tmp_path: Path
) -> None:
    done = subprocess.run(
        fairlead_command(*command.format(file=TWO_HOSTS, folder=tmp_path / "out").split()),
        env=fairlead_environment(tmp_path), capture_output=True, text=True, timeout=TIMEOUT_S,
        check=False, preexec_fn=take_little,
    )  # fmt: skip
    told = done.stderr.splitlines()[-1]
    assert done.returncode == 1 and told.startswith("ERROR ") and file in told, done.stderr


@pytest.mark.parametrize(
    ("write", "file"),
    [
        (lambda state: Registry(state).write(Running("mine", "/mine.yaml", "/state", None, {})),
         "running/mine.json"),
        (lambda state: Registry(state).keep_file("mine", TWO_HOSTS), "running/mine.yaml"),
        (lambda state: write_private(state / "a.pem", "a key, and a certificate"), "a.pem"),
    ],
)  # fmt: skip
def test_of_what_a_start_needs_the_file_is_named_and_no_draft_is_left(
    write: Callable[[Path], None], file: str, tmp_path: Path
) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    take_little()
    try:
        with pytest.raises(OSError, match="File too large") as caught:
            write(tmp_path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert caught.value.filename == str(tmp_path / file)
    assert files(tmp_path) == []


def test_a_file_that_cannot_be_opened_is_left_as_it_was(tmp_path: Path) -> None:
    file = tmp_path / "compose.yaml"
    file.write_text("services: {}\n")
    with pytest.raises(PermissionError), written(file, file):
        raise PermissionError(13, "Permission denied", str(file))
    assert file.read_text() == "services: {}\n"
