"""A copy of the robot panda under another name, in a folder of robots of one's own."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import yaml

from fairlead.paths import robot_dir

NAME = "mine"


def own_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, **texts: tuple[str, str]) -> Path:
    """Make it; returns its folder.

    Args:
        texts: for ``yaml``, ``urdf`` or ``xml``, what to replace in that file, and by what.
    """
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(tmp_path))
    folder = tmp_path / NAME
    shutil.copytree(robot_dir("panda"), folder)
    (folder / "panda.xml").rename(folder / "mine.xml")
    manifest = folder / "robot.yaml"
    manifest.write_text(manifest.read_text().replace("id: panda\n", "id: mine\n", 1))
    files = {"yaml": "robot.yaml", "urdf": "panda.urdf", "xml": "mine.xml"}
    for kind, (old, new) in texts.items():
        path = folder / files[kind]
        assert old in path.read_text()
        path.write_text(path.read_text().replace(old, new))
    return folder


def with_hardware(folder: Path, open_: dict[str, str]) -> None:
    """The robot gets a profile for hardware, with the simulator's limits.

    Args:
        open_: what of it is open, and why.
    """
    manifest = folder / "robot.yaml"
    document = yaml.safe_load(manifest.read_text())
    document["safety"]["hardware"] = document["safety"]["sim"] | {"lockstep_allowed": False}
    document["to_confirm"] = open_
    manifest.write_text(yaml.safe_dump(document))
