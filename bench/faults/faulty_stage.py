"""The light robot with a HAL that breaks when it is told to."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import yaml

from bench.faults.faulty_hal import CAMERA, FAULT_FILE
from bench.faults.live_stage import SKILL, Changes, LiveStage, live_stage
from fairlead.paths import gate_config
from fairlead.robot.gate_file import sealed

ROBOT, HAL = "panda_mobile", "bench.faults.faulty_hal"
STOP_RAMP_MS = 200
SEEING, SEEING_AGE_TICKS = "seeing-motion", 6


class FaultyStage(LiveStage):
    """fault_file: holds the name of the fault the robot has now."""

    fault_file: Path

    def fault(self, name: str) -> int:
        """Give the robot a fault, or none with "".

        Returns:
            CLOCK_MONOTONIC just before [ns].
        """
        now_ns = time.monotonic_ns()
        new = self.fault_file.with_suffix(".new")
        new.write_text(name, encoding="ascii")
        new.replace(self.fault_file)
        return now_ns


def strict_gate_file(folder: Path) -> Path:
    """The simulator's gate file with the limits of a robot that does what it is told.

    A simulated arm may lag, swing and press far more than a real one should be allowed to.
    """
    content = json.loads(gate_config(ROBOT, "sim").read_text())
    content["protocol"] |= {"stuck_ticks": 3, "stop_ramp_ms": STOP_RAMP_MS}
    for joint in content["joints"]:
        joint |= {"contact_limit": 200.0, "encoder_step": 1e-6, "dead_band": 1e-3}
    modes = {part["name"]: part["modes"] for part in content["parts"]}
    exact = {"gain": [1.0, 1.0], "tracking": [0.05, 0.05, 0.05]}
    modes["base"]["joint_velocity"] |= exact
    modes["arm"]["cartesian_delta"] |= {"linear_tracking": 0.05, "angular_tracking": 0.2}
    modes["gripper"]["gripper_position"] |= {"slip_limit": 0.005}
    file = folder / "gate.json"
    file.write_text(sealed(json.dumps(content)), encoding="utf-8")
    return file


@contextmanager
def faulty_stage(folder: Path) -> Iterator[FaultyStage]:
    """All services, and no fault yet."""
    file = folder / "fault"
    file.write_text("", encoding="ascii")
    path = os.pathsep.join(filter(None, [str(Path.cwd()), os.environ.get("PYTHONPATH")]))
    usual, strict = str(gate_config(ROBOT, "sim")), str(strict_gate_file(folder))

    def command(service: str, words: list[str]) -> list[str]:
        if service == "hal":
            words = [HAL if word == "fairlead.hal.serve" else word for word in words]
        return [strict if word == usual else word for word in words]

    environment = {"hal": {FAULT_FILE: str(file), "PYTHONPATH": path}}
    changes = Changes(environment=environment, command=command)
    with live_stage(folder, changes) as robot:
        stage = FaultyStage(robot.robot)
        stage.fault_file = file
        yield stage


@contextmanager
def seeing_stage(folder: Path) -> Iterator[FaultyStage]:
    """The same robot under a skill that looks through its camera."""
    with faulty_stage(folder) as robot:
        skills = folder / "skills"
        manifest = yaml.safe_load((skills / SKILL / "rskill.yaml").read_text(encoding="utf-8"))
        eye = {"camera": CAMERA.name, "width": CAMERA.width, "height": CAMERA.height}
        manifest |= {"id": SEEING, "images": {"eye": eye}, "age_max_ticks": SEEING_AGE_TICKS}
        (skills / SEEING).mkdir()
        (skills / SEEING / "rskill.yaml").write_text(yaml.safe_dump(manifest), encoding="utf-8")
        stage = FaultyStage(robot.robot, SEEING)
        stage.fault_file = robot.fault_file
        yield stage
