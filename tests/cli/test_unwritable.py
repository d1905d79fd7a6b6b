"""Results that cannot be written: said before the work that would make them."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from bench.page import Write
from tests.cli.command import fairlead_here as fairlead
from tests.learn.drawn import EXPERT, drawn_dataset, drawn_episode, drawn_pictures

PANDA = "panda-joint-reach"


@pytest.fixture
def data(tmp_path: Path) -> Path:
    (tmp_path / "file").write_text("", encoding="utf-8")
    drawn_pictures(tmp_path / "pictures", 1, 2)
    return drawn_dataset(tmp_path / "states", drawn_episode(1), drawn_episode(2))


@pytest.mark.parametrize("out", ["/proc/nowhere", "{}/file/below", "/dev/full/below"])
@pytest.mark.parametrize(
    ("command", "who"),
    [
        ("train {}/states --out OUT", "train: --out"),
        ("train {}/pictures --out OUT", "train: --out"),
        ("export lerobot {}/states OUT", "export lerobot"),
        (f"dataset record {EXPERT.id} --episodes 1 --out OUT", "dataset record: --out"),
        (f"dataset record {EXPERT.id} --episodes 1 --deployed --out OUT", "dataset record: --out"),
        (f"eval {PANDA} --seeds 0 -d panda_mujoco --pacing lockstep --out OUT", "eval: --out"),
        ("parity --out OUT", "parity: --out"),
        ("robot capsules panda --picture OUT.png", "robot capsules: --picture"),
    ],
)
def test_what_cannot_be_written_is_said_before_anything_is_computed(
    command: str, who: str, out: str, data: Path
) -> None:
    place = out.format(data.parent)
    words = command.format(data.parent).replace("OUT", place).split()
    done = fairlead(*words, state=data.parent / "registry")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith(f"ERROR {who}: cannot write to {words[-1]}: "), done.stderr


def test_a_bench_s_page_that_cannot_be_written_is_refused_with_the_command_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--write", action=Write, page=Path("/proc/nowhere.md"))
    parser.add_argument("--read", action=Write)
    assert parser.parse_args(["--read"]).read is True and parser.parse_args([]).read is False
    with pytest.raises(SystemExit):
        parser.parse_args(["--write"])
    assert "--write: cannot write to /proc/nowhere.md: " in capsys.readouterr().err
