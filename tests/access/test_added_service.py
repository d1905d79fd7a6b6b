"""A service that was added to the file while the others run says why nobody lets it in."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from bench.faults.live_stage import live_stage
from tests.access.spoken import assert_says, running

pytestmark = [pytest.mark.processes, pytest.mark.timeout(240)]


def test_it_names_those_that_do_not_know_its_password(tmp_path: Path) -> None:
    with live_stage(tmp_path / "stage") as robot:
        content = yaml.safe_load(robot.robot.scratch.file.read_text(encoding="utf-8"))
        content["services"]["second"] = {"run": "skill_runner"}
        file = tmp_path / "more.yaml"
        file.write_text(yaml.safe_dump(content), encoding="utf-8")
        words = ["service", str(file), "second", "--state-dir", str(tmp_path / "second")]
        with running(tmp_path, *words) as second:
            for name in ("hal", "safety", "state_assembler"):
                assert_says(
                    second,
                    f"WARNING fairlead-skill-runner: {name} gives second no link: what listens "
                    "there hangs, is another program, or was started before second was in the "
                    "file; see: fairlead ps",
                )
