"""Folders of what proves names, and those above them, are this user's alone whatever the umask."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from fairlead.paths import repo_root
from tests.cli.command import fairlead_command

ONE_HOST, TWO_HOSTS = "panda_mobile_sim.yaml", "panda_mobile_two_hosts.yaml"


@pytest.mark.processes
@pytest.mark.parametrize(
    ("command", "file"), [(("certs", "new"), TWO_HOSTS), (("status", "-d"), ONE_HOST)]
)
def test_nobody_else_may_write_beside_them(
    command: tuple[str, str], file: str, tmp_path: Path
) -> None:
    kept = {name: value for name, value in os.environ.items() if name.startswith(("PATH", "LANG"))}
    subprocess.run(
        fairlead_command(*command, str(repo_root() / "compose" / file)),
        env=kept | {"HOME": str(tmp_path)}, umask=0, capture_output=True, check=False,
    )  # fmt: skip
    made = [path for path in tmp_path.rglob("*") if path.is_dir()]
    assert tmp_path / ".local/state/fairlead/access" in made
    assert {path: oct(path.stat().st_mode & 0o777) for path in made} == dict.fromkeys(made, "0o700")
