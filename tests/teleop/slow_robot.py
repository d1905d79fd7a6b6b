"""A simulated arm that a person drives, and a skill to take it over from."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import yaml

from fairlead.deploy.registry import Registry
from fairlead.paths import SKILLS_VARIABLE, deployment_path, repo_root
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)


@contextmanager
def slow_robot(folder: Path, name: str, skill: str, step_rad: float) -> Iterator[ScratchRobot]:
    """A deployment in MuJoCo at the robot's own pace; ``slow-reach`` is ``skill``, taking its time.

    Args:
        folder: empty; gets the skill, the deployment and its state.
    """
    manifest = yaml.safe_load((repo_root() / "rskills" / skill / "rskill.yaml").read_text())
    manifest["id"] = "slow-reach"
    manifest["policy"]["options"]["step_rad"] = step_rad
    home = folder / "rskills" / "slow-reach"
    home.mkdir(parents=True)
    (home / "rskill.yaml").write_text(yaml.safe_dump(manifest))
    options = ScratchOptions(pacing="realtime", options={"hal": {"start_spread_rad": 0.0}})
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SKILLS_VARIABLE, str(folder / "rskills"))
        scratch = make_scratch(deployment_path(name), folder / "up", options)
        with scratch_robot(scratch, Registry(folder / "registry")) as robot:
            yield robot
