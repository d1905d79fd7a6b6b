"""``fairlead jog`` in a world that waits for rows: each acts in the tick it was made for."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fairlead.deploy.registry import Registry
from fairlead.messages import Hold
from fairlead.paths import deployment_path
from fairlead_tools.supervisor.scratch import ScratchOptions, make_scratch, scratch_robot
from tests.cli.command import fairlead_here as fairlead

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]


def test_a_tool_arrives_and_no_tick_gets_a_row_that_was_meant_for_silence(tmp_path: Path) -> None:
    source = deployment_path("ur5e_mujoco")
    scratch = make_scratch(source, tmp_path / "up", ScratchOptions(pacing="lockstep"))
    with (
        scratch_robot(scratch, Registry(tmp_path / "registry")) as robot,
        robot.client.joint_states(queue=10_000) as states,
    ):
        words = ("jog", "z", "-50mm", "--deployment", str(scratch.file))
        done = fairlead(*words, state=tmp_path / "registry")
        assert done.returncode == 0, done.stderr
        moved = r"^z moved -0\.0(4[89]|5[012])\d+ m of -0\.0500 m: cartesian_delta comes within 0\."
        assert re.search(moved, done.stdout, re.M), done.stdout
        newest, rows = robot.client.gate_status().state_tick, []
        while (state := states.next(5.0)) is not None and state.tick < newest:
            rows += [one.row for one in state.acted if one.hold == Hold.NONE]
    assert rows and not any(rows)
