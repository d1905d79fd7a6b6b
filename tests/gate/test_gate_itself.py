"""What the gate finds of itself and of what it told to stop: G043 and G050, in a real process."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bench.equipment.gate_scene import Scene
from fairlead.messages import GateState
from fairlead.robot.gate_file import sealed
from fairlead.wire.gate_checks import CHECKS
from tests.gate.decision_logs import judge, logs

pytestmark = pytest.mark.processes


def with_protocol(config: Path, folder: Path, **changes: int) -> Path:
    """The gate file with other numbers of the protocol."""
    file = json.loads(config.read_text())
    file["protocol"] |= changes
    path = folder / "gate.changed.json"
    path.write_text(sealed(json.dumps(file)))
    return path


def test_a_gate_that_misses_its_own_deadline_three_times_stops_and_is_judged_alike(
    config: Path, tmp_path: Path
) -> None:
    impossible = with_protocol(config, tmp_path, step_deadline_us=1)
    scene = Scene(impossible, tmp_path / "gate", "realtime")
    try:
        scene.meet_hal()
        scene.arm()
        status = scene.wait_state(GateState.STOPPED)
        assert status.cause.startswith("stopped: G050 step: ")
        assert status.cause.endswith(" us, limit 1 us (step_deadline_us, three times in 60 s)")
        assert dict(status.counters)["G050"] == 3
        assert scene.gate.stop() == 0
    finally:
        scene.close()
    exit_status, found = judge(logs(scene)[-1])
    assert (exit_status, found["identical"]) == (0, True), found


def test_the_status_counts_every_check(config: Path, tmp_path: Path) -> None:
    scene = Scene(config, tmp_path / "gate", "lockstep")
    try:
        counted = [name for name, _ in scene.status().counters if name.startswith("G")]
    finally:
        scene.close()
    assert counted == [f"G{number:03d}" for number in sorted(CHECKS)]


def test_lockstep_waits_for_a_slow_gate(config: Path, tmp_path: Path) -> None:
    impossible = with_protocol(config, tmp_path, step_deadline_us=1)
    scene = Scene(impossible, tmp_path / "gate", "lockstep")
    try:
        scene.meet_hal()
        scene.arm()
        for _ in range(5):
            scene.next_tick(scene.hal.held())
        assert scene.status().state == GateState.ARMED
        assert dict(scene.status().counters)["G050"] == 0
    finally:
        scene.close()


def test_a_robot_that_falls_silent_is_stopped_and_then_latched(
    config: Path, tmp_path: Path
) -> None:
    scene = Scene(with_protocol(config, tmp_path, stop_ramp_ms=100), tmp_path / "gate", "realtime")
    try:
        scene.meet_hal()
        scene.arm()
        stopped = scene.wait_state(GateState.STOPPED)
        assert stopped.cause.startswith("stopped: G011 state age: ")
        latched = scene.wait_state(GateState.LATCHED)
        assert latched.cause.startswith(
            "latched: no standstill 100 ms after the stop: G043 state age: "
        )
        assert latched.fix == f"fairlead reset {latched.latch_id:016x}"
        assert latched.stop_ids == stopped.stop_ids
    finally:
        scene.close()
