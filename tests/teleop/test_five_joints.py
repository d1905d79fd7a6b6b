"""A person leads the tool of an arm that cannot turn it as told: the turn is left free."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fairlead.deploy.registry import Registry
from fairlead.messages import FloatArray, floats
from fairlead.paths import deployment_path
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.cli.command import fairlead
from tests.teleop.drives import drive


def test_its_tool_has_no_axes_of_rotation() -> None:
    assert drive("so101", "arm", "cartesian_delta").names == ("x", "y", "z")


def tool(running: ScratchRobot) -> FloatArray:
    """Where it is in base_link [m]."""
    for batch in running.client.transforms():
        for one in batch.transforms:
            if (one.parent, one.child) == ("base_link", "tool"):
                return floats(one.translation)
    raise AssertionError


@pytest.mark.processes
def test_its_tool_is_jogged_where_it_is_told(tmp_path: Path) -> None:
    options = ScratchOptions(pacing="lockstep", options={"hal": {"start_spread_rad": 0.0}})
    scratch = make_scratch(deployment_path("so101_mujoco"), tmp_path / "up", options)
    with scratch_robot(scratch, Registry(tmp_path / "registry")) as running:
        start = tool(running)
        words = ("jog", "y", "30mm", "--deployment", str(scratch.file))
        done = fairlead(*words, state=tmp_path / "registry")
        assert done.returncode == 0, done.stdout + done.stderr
        np.testing.assert_allclose(tool(running) - start, [0.0, 0.03, 0.0], atol=4e-3)
