"""A disk that takes no more bytes, which Python says without a file: it is named all the same."""

from __future__ import annotations

import errno
import os
import resource
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from fairlead.deploy.credentials import write_private
from fairlead.deploy.process_table import process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead.paths import repo_root, written
from fairlead_tools.learn.dataset import add, read_header
from fairlead_tools.writable import BLOCK, not_written
from tests.cli.command import TIMEOUT_S, fairlead_command, fairlead_environment
from tests.learn.drawn import drawn_dataset, drawn_episode

TWO_HOSTS = repo_root() / "compose" / "panda_mobile_two_hosts.yaml"
ONE_HOST = repo_root() / "compose" / "panda_mujoco.yaml"


def take_little(most_bytes: int = 20) -> None:
    """Let no file of this process have more bytes."""
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, hard))


def take_two_blocks() -> None:
    take_little(2 * BLOCK)


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


@pytest.mark.processes
def test_an_export_that_finds_no_room_says_where_and_leaves_nothing(tmp_path: Path) -> None:
    data = drawn_dataset(tmp_path / "data", drawn_episode(1, 200))
    target = tmp_path / "lerobot"
    done = subprocess.run(
        fairlead_command("export", "lerobot", str(data), str(target)),
        env=fairlead_environment(tmp_path), capture_output=True, text=True, timeout=TIMEOUT_S,
        check=False, preexec_fn=take_two_blocks,
    )  # fmt: skip
    said = f"ERROR export lerobot: cannot write to {target}: File too large\n"
    assert (done.returncode, done.stderr) == (1, said)
    assert files(target) == []


def test_of_a_recording_that_finds_no_room_the_file_is_named_and_whole_episodes_stay(
    tmp_path: Path,
) -> None:
    data = drawn_dataset(tmp_path, drawn_episode(1))
    whole, header = sorted(files(data)), read_header(data)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    take_two_blocks()
    try:
        with pytest.raises(OSError, match="File too large") as caught:
            add(data, header, drawn_episode(2, 200))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert caught.value.filename == str(data / "episode_000002.npz")
    assert sorted(files(data)) == whole and read_header(data) == header


def test_of_a_full_disk_is_said_how_much_room_is_left(tmp_path: Path) -> None:
    error = OSError(errno.ENOSPC, "Error writing bytes to file. Detail: [errno 28] No space left")
    said = str(not_written("export lerobot", tmp_path / "new", error))
    wanted = f"export lerobot: cannot write to {tmp_path}/new: No space left on device ("
    assert said.startswith(wanted) and said.endswith(" MB are free there)"), said


@pytest.mark.processes
def test_a_service_that_could_not_be_listed_again_is_not_restarted_and_goes_on(
    tmp_path: Path,
) -> None:
    with subprocess.Popen(["sleep", "60"]) as runner:
        services = {"runner": ServiceEntry(process_id(runner.pid), True, 0)}
        own = process_id(os.getpid())
        Registry(tmp_path).write(Running("mine", str(ONE_HOST), str(tmp_path), own, services))
        done = subprocess.run(
            fairlead_command("restart", "runner"), env=fairlead_environment(tmp_path),
            capture_output=True, text=True, timeout=TIMEOUT_S, check=False, preexec_fn=take_little,
        )  # fmt: skip
        still_runs = runner.poll() is None
        runner.kill()
    said = f"ERROR restart runner: cannot write to {tmp_path}/running: File too large\n"
    assert (done.returncode, done.stderr) == (1, said)
    assert still_runs


def test_a_file_that_cannot_be_opened_is_left_as_it_was(tmp_path: Path) -> None:
    file = tmp_path / "compose.yaml"
    file.write_text("services: {}\n")
    with pytest.raises(PermissionError), written(file, file):
        raise PermissionError(13, "Permission denied", str(file))
    assert file.read_text() == "services: {}\n"
