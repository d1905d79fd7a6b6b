"""What a driving base does to an arm is less than robot.yaml declares."""

from __future__ import annotations

import pytest

from bench.soundness.base_drift import BaseDrift
from fairlead.robot.manifest import load_robot


@pytest.mark.processes
@pytest.mark.simulator
def test_an_arm_told_zeros_under_a_driving_base_is_left_behind_by_less_than_declared() -> None:
    base = load_robot("panda_mobile").profile("sim").base
    assert base is not None
    drift = BaseDrift()
    try:
        found = drift.episode(1047)
    finally:
        drift.loop.close()
    assert found is not None
    assert 0.02 < found.tool_m < base.tool_drift_m
    assert 0.0 < found.nearer_m < base.clearance_drift_m
