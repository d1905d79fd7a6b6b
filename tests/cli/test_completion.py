"""Completion as a shell asks for it."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.cli.command import fairlead_command, fairlead_environment

pytestmark = pytest.mark.processes

ASKED = {
    "fairlead run oracle-c": "oracle-counter-to-cabinet",
    "fairlead skill show panda-j": "panda-joint-reach",
    "fairlead robot show dual": "dual_panda",
    "fairlead up panda_mu": "panda_mujoco",
    "fairlead status -d panda_mu": "panda_mujoco",
}


@pytest.mark.parametrize("line", ASKED)
def test_names_are_completed(line: str, tmp_path: Path) -> None:
    words = {"COMP_WORDS": line, "COMP_CWORD": str(len(line.split()) - 1)}
    done = subprocess.run(
        fairlead_command(),
        env=fairlead_environment(tmp_path) | words | {"_FAIRLEAD_COMPLETE": "complete_bash"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stdout.split() == [ASKED[line]], done.stderr
