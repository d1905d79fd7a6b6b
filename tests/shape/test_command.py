"""``fairlead robot capsules`` as a person uses it, for a robot of their own."""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib.image
import pytest

from fairlead.robot.capsules import load_capsules
from fairlead.robot.manifest import load_robot
from tests.cli.command import fairlead_here as fairlead
from tests.shape.own_robot import NAME, own_robot

HOME = "panda_joint4: -2.2\n    panda_joint5: 0.0\n    panda_joint6: 2.0\n"


def test_it_writes_the_file_and_the_picture_and_the_file_is_current(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_robot(tmp_path, monkeypatch)
    (folder / "capsules.yaml").unlink()
    picture = tmp_path / "mine.png"
    done = fairlead("robot", "capsules", NAME, "--picture", str(picture), state=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "panda_link0, panda_link1" in done.stdout
    told = done.stderr.splitlines()
    assert told[0] == f"{NAME}: its geometry, and whether its description agrees"
    assert told[-1].startswith("pair 44 of 44 in 20000 poses: ")
    assert "no: joined by panda_joint1" in done.stdout
    assert f"wrote {folder / 'capsules.yaml'}; review it" in done.stdout
    made = load_capsules(load_robot(NAME))
    shipped = load_capsules(load_robot("panda"))
    assert made.source.startswith("fairlead robot capsules mine")
    assert (made.capsules, made.checked_pairs) == (shipped.capsules, shipped.checked_pairs)
    assert matplotlib.image.imread(picture).shape[0] > 500
    assert fairlead("robot", "compile", NAME, state=tmp_path).returncode == 0


def test_check_says_what_is_wrong_draws_it_and_leaves_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_robot(tmp_path, monkeypatch)
    path = folder / "capsules.yaml"
    text = path.read_text()
    text = text.replace("radius_m: 0.055}", "radius_m: 0.05}")
    text = text.replace("  - [0, 2]  #", "  - [0, 1]  #")
    text = text.replace("[panda_link0, panda_link1]", "[panda_link0, panda_link2]")
    path.write_text(text)
    wrong = path.read_text()
    picture = tmp_path / "mine.png"
    words = ("robot", "capsules", NAME, "--check", "--picture", str(picture))
    done = fairlead(*words, state=tmp_path)
    assert done.returncode == 1
    assert f"wrote {picture}\n" in done.stdout and picture.stat().st_size > 0
    assert "ERROR mine: panda_link5 reaches 0.0050 m out of its capsules" in done.stderr
    assert "ERROR mine: pair [0, 2] should be checked" in done.stderr
    assert "ERROR mine: pair [0, 1] should not be checked" in done.stderr
    assert path.read_text() == wrong


def test_a_robot_whose_rest_is_a_collision_is_refused_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folded = HOME.replace("-2.2", "-3.0").replace("2.0", "0.2")
    folder = own_robot(tmp_path, monkeypatch, yaml=(HOME, folded))
    before = (folder / "capsules.yaml").read_text()
    done = fairlead("robot", "capsules", NAME, state=tmp_path)
    assert done.returncode == 1
    assert "robot capsules: mine: expected panda_link" in done.stderr
    assert "at least 0.01 m apart where the robot rests" in done.stderr
    assert "Traceback" not in done.stderr
    assert (folder / "capsules.yaml").read_text() == before


def test_pairs_that_are_never_near_go_only_if_one_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_robot(tmp_path, monkeypatch)
    kept = len(load_capsules(load_robot(NAME)).checked_pairs)
    done = fairlead("robot", "capsules", NAME, "--drop-margin-m", "0.1", "--json", state=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    pairs = json.loads(done.stdout)["pairs"]
    dropped = [
        pair for pair in pairs if pair["why_not"] == "never nearer than 0.11 m (20000 poses)"
    ]
    assert dropped
    assert all(pair["least_m"] > 0.11 for pair in dropped)
    assert all(pair["least_m"] <= 0.11 for pair in pairs if pair["checked"])
    assert sum(pair["checked"] for pair in pairs) == kept - len(dropped)
    assert "--drop-margin-m 0.1" in (folder / "capsules.yaml").read_text()


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (("--model", "none.xml"), "expected an MJCF file, got none at none.xml"),
        (("--samples", "9999"), "Input should be greater than or equal to 10000"),
        (("--max-per-link", "0"), "Input should be greater than or equal to 1"),
        (("--picture", "/nowhere/at/all.png"), "cannot write /nowhere/at/all.png"),
    ],
)
def test_mistakes_are_told_without_a_traceback(
    options: tuple[str, str], complaint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own_robot(tmp_path, monkeypatch)
    done = fairlead("robot", "capsules", NAME, *options, state=tmp_path)
    assert done.returncode != 0
    assert complaint in " ".join(done.stderr.replace("│", " ").split())
    assert "Traceback" not in done.stderr
