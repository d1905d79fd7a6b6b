"""Fixtures: the compiled configuration, a state folder, and a scene with a gate in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal

import pytest

from bench.equipment.gate_scene import Scene
from bench.equipment.running_gate import ROBOT
from fairlead.paths import gate_config


@pytest.fixture
def config() -> Path:
    return gate_config(ROBOT, "sim")


@pytest.fixture
def make_scene(config: Path, tmp_path: Path) -> Iterator[Callable[..., Scene]]:
    scenes: list[Scene] = []

    def make(pacing: Literal["realtime", "lockstep"] = "lockstep") -> Scene:
        scenes.append(Scene(config, tmp_path / "gate", pacing))
        return scenes[-1]

    yield make
    for scene in scenes:
        scene.close()


@pytest.fixture
def scene(make_scene: Callable[..., Scene]) -> Scene:
    """A gate in lockstep; nothing has been said to it."""
    return make_scene()
