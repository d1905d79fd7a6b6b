"""Decision logs of a scene's gate, and what ``fairlead-decisions judge`` says about them."""

from __future__ import annotations

import json
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np

from bench.equipment.gate_scene import Scene
from bench.equipment.mailbox import DEADLINE_S
from fairlead.messages import Outcome, pack_floats
from fairlead.paths import decisions_binary


def judge(*words: object) -> tuple[int, dict[str, Any]]:
    """Exit status and document of ``fairlead-decisions judge``; {} if it refused to judge."""
    status, text = judged_text(*words, "--json")
    document = json.loads(text)
    return status, {} if "error" in document else document


def judged_text(*words: object) -> tuple[int, str]:
    """Exit status and text of ``fairlead-decisions judge``."""
    done = subprocess.run(
        [str(decisions_binary()), "judge", *map(str, words)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    return done.returncode, done.stdout + done.stderr


def logs(scene: Scene) -> list[Path]:
    """The logs of the scene's gate, oldest first."""
    return sorted((scene.state_dir / "decisions").glob("*.decisions"))


def moves(scene: Scene, step_m: float, rows: int = 4) -> Any:
    """A chunk whose rows all move the arm by ``step_m`` along x."""
    values = np.zeros((rows, 6))
    values[:, 0] = step_m
    return scene.chunk(rows, parts=(scene.arm_part(rows, values=pack_floats(values)),))


def drive(scene: Scene, steps: tuple[float, ...]) -> list[Outcome]:
    """One chunk per step width; what is released is executed to its last row."""
    outcomes = []
    for step_m in steps:
        verdict = scene.send(moves(scene, step_m))
        outcomes.append(Outcome(verdict.outcome))
        if verdict.outcome == Outcome.REFUSED:
            scene.next_tick()
            continue
        for row in range(verdict.released_last - verdict.released_first + 1):
            scene.acted_on(verdict, row)
    return outcomes


def tightened(config: Path, tmp_path: Path, linear_limit: float) -> Path:
    """The configuration with another limit for the arm's translation in one row."""
    file = json.loads(config.read_text())
    file["parts"][0]["modes"]["cartesian_delta"]["linear_limit"] = linear_limit
    path = tmp_path / "tighter.json"
    path.write_text(json.dumps(file))
    return path


def wait_until_recorded(path: Path, **counts: int) -> dict[str, Any]:
    """Until the log of a running gate says so: its writer is a moment behind the decisions."""
    deadline = time.monotonic() + DEADLINE_S
    while True:
        status, found = judge(path)
        assert status == 0, found
        if all(found[name] == count for name, count in counts.items()):
            return found
        assert time.monotonic() < deadline, f"expected {counts}, the log has {found}"
