"""``fairlead dataset record``: which seeds, and where to."""

from __future__ import annotations

from pathlib import Path

import pytest

from fairlead_tools.learn.dataset import read_header
from tests.cli.command import fairlead, fairlead_here

SKILL = "oracle-reach-cube"


@pytest.mark.processes
@pytest.mark.simulator
def test_with_only_a_number_of_episodes_seeds_are_from_0_on_and_the_folder_is_the_skill_s(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("dataset", "record", SKILL, "--episodes", "2", "--ticks", "2")
    done = fairlead(*words, "-d", "ur5e_robosuite", state=tmp_path / "registry")
    assert done.returncode == 0, done.stdout + done.stderr
    folder = Path("out/datasets") / SKILL
    assert done.stdout == f"{folder}: 0 of 2 episodes succeeded\n"
    assert [one.seed for one in read_header(tmp_path / folder).episodes] == [0, 1]


def test_a_number_of_episodes_or_seeds_must_be_said(tmp_path: Path) -> None:
    done = fairlead_here("dataset", "record", SKILL, state=tmp_path)
    assert done.returncode == 1
    assert done.stderr == (
        "ERROR dataset record: expected --episodes N, --seeds FIRST:END or both, got neither\n"
    )
