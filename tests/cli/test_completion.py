"""Completion as a shell asks for it."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.command import fairlead, fairlead_here

Start = Callable[..., subprocess.CompletedProcess[str]]
ASKED = {
    "fairlead run oracle-c": "oracle-counter-to-cabinet",
    "fairlead skill show panda-j": "panda-joint-reach",
    "fairlead robot show dual": "dual_panda",
    "fairlead up panda_mu": "panda_mujoco",
    "fairlead status -d panda_mu": "panda_mujoco",
}


@pytest.mark.parametrize(
    ("line", "start"),
    [
        pytest.param("fairlead up panda_mu", fairlead, marks=pytest.mark.processes),
        *((line, fairlead_here) for line in ASKED),
    ],
)
def test_names_are_completed(
    line: str, start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(line.split()) - 1))
    monkeypatch.setenv("_FAIRLEAD_COMPLETE", "complete_bash")
    done = start(state=tmp_path)
    assert done.stdout.split() == [ASKED[line]], done.stderr
