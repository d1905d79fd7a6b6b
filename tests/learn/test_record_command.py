"""``fairlead dataset record``: which seeds, and where to."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from fairlead_tools.learn import record
from fairlead_tools.learn.dataset import Episode, read_header
from tests.cli.command import fairlead_here
from tests.learn.drawn import EXPERT, drawn_episode

SKILL = "oracle-reach-cube"


@pytest.mark.processes
@pytest.mark.simulator
def test_with_only_a_number_of_episodes_seeds_are_from_0_on_and_the_folder_is_the_skill_s(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("dataset", "record", SKILL, "--episodes", "2", "--ticks", "2")
    done = fairlead_here(*words, "-d", "ur5e_robosuite", state=tmp_path / "registry")
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


def test_ctrl_c_keeps_the_episodes_that_are_whole_and_says_how_many_are_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def two(*_: object) -> Iterator[Episode]:
        yield drawn_episode(0)
        yield drawn_episode(1, succeeded=False)
        raise KeyboardInterrupt

    monkeypatch.setattr(record, "record", two)
    out = tmp_path / "out"
    words = ("dataset", "record", EXPERT.id, "--episodes", "5", "--out", str(out))
    done = fairlead_here(*words, state=tmp_path)
    assert (done.returncode, done.stderr) == (130, "interrupted\n")
    assert done.stdout == f"{out}: 1 of 2 episodes succeeded, 3 not recorded\n"
    assert len(read_header(out).episodes) == 2
