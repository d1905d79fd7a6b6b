"""Pipes and devices where a file is expected: refused by name, and not read for ever."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.paths import repo_root
from fairlead.regular_file import regular
from fairlead_skill_runner.policies.onnx_files import HashedFile
from tests.cli.command import fairlead, fairlead_here

WHAT = "a pipe or a device, not a file"
BY_THE_SYSTEM = ("why", "judge", "logs")
"""Their error is the system's own, by which a command gives up its process's output, too."""
LOG = repo_root() / "services/safety/test/corpus/panda.decisions"


@pytest.mark.processes
@pytest.mark.parametrize(
    "words",
    [
        ("run", "./pipe.yaml"),
        ("plot", "pipe.yaml"),
        ("why", "--log", "pipe.yaml"),
        ("judge", "pipe.yaml"),
        ("judge", str(LOG), "--config", "pipe.yaml"),
        ("skill", "check", "go-to", "--stats", "pipe.yaml"),
        ("skill", "install", "."),
        ("robot", "new", "mine", "--urdf", "pipe.yaml"),
        ("logs", "--state-dir", "."),
    ],
)
def test_a_command_does_not_wait_for_a_pipe(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "logs").mkdir()
    for name in ("pipe.yaml", "rskill.yaml", "logs/hal.log"):
        os.mkfifo(tmp_path / name)
    monkeypatch.chdir(tmp_path)
    start = fairlead if words[0] in BY_THE_SYSTEM else fairlead_here
    done = start(*words, state=tmp_path)
    assert done.returncode == 1, done.stdout
    assert WHAT in done.stderr and done.stderr.count("ERROR") == 1


def test_a_skill_with_a_link_to_a_device_is_not_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "go-to"
    shutil.copytree(repo_root() / "rskills" / "go-to", folder)
    folder = folder.rename(tmp_path / "mine")
    text = (folder / "rskill.yaml").read_text().replace("id: go-to", "id: mine")
    (folder / "rskill.yaml").write_text(text)
    (folder / "policy.onnx").symlink_to("/dev/zero")
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "skills"))
    done = fairlead_here("skill", "install", str(folder), state=tmp_path)
    assert done.returncode == 1, done.stdout
    said = f"ERROR skill install: {folder}/policy.onnx: cannot be read: {WHAT}\n"
    assert done.stderr == said
    assert not list((tmp_path / "skills").iterdir())


def test_a_network_that_is_a_pipe_or_a_device_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "policy.onnx")
    (tmp_path / "zero.onnx").symlink_to("/dev/zero")
    for name in ("policy.onnx", "zero.onnx"):
        with pytest.raises(ConfigError, match=f"{name}: cannot be read: {WHAT}"):
            HashedFile(file=name, sha256="0" * 64).read(tmp_path)


def test_files_and_links_to_them_may_be_read(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("text")
    (tmp_path / "link").symlink_to("file")
    assert regular(tmp_path / "link").read_text() == "text"
    for name in ("file", "link"):
        assert regular(tmp_path / name) == tmp_path / name
    with pytest.raises(FileNotFoundError):
        regular(tmp_path / "none")
