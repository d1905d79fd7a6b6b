"""``fairlead calibrate so101`` as a person uses it, who is a hand on an emulated arm."""

from __future__ import annotations

import subprocess
from pathlib import Path

from bench.equipment.emulated_arm import EmulatedArm
from bench.equipment.live_robot import wait_for
from tests.cli.command import fairlead_command, fairlead_environment
from tests.so101.arm import ROBOT


def calibrate(
    arm: EmulatedArm, file: Path, *options: str, trigger: tuple[float, float] | None = None
) -> tuple[int, str]:
    """Do what the command says, joint by joint; its code and last line.

    ``trigger``: the ends of the last joint's way, where it is no jaw.
    """
    ways = [(joint.lower, joint.upper) for joint in ROBOT.joints]
    ways[-1] = trigger or ways[-1]
    words = ("calibrate", "so101", "--port", str(arm.port), "--name", str(file))
    with subprocess.Popen(
        fairlead_command(*words, *options),
        env=fairlead_environment(file.parent),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        assert process.stdin is not None and process.stdout is not None
        assert "goes limp" in process.stdout.readline()
        for servo_id, joint in enumerate(ROBOT.joints, start=1):
            for end, position in zip(("lower", "upper"), ways[servo_id - 1], strict=True):
                asked = process.stdout.readline()
                assert asked.startswith(f"{joint.name}: move it to its {end} end"), asked
                move(arm, servo_id, position)
                process.stdin.write("\n")
                process.stdin.flush()
        said = process.stdout.read().splitlines()
        process.wait(timeout=60.0)
        return process.returncode, said[-1]


def move(arm: EmulatedArm, servo_id: int, position: float) -> None:
    """The hand takes the joint there, and it has arrived."""
    arm.order(f"pull {servo_id} {position}")
    wait_for(lambda: abs(float(arm.order(f"where {servo_id}")) - position) < 0.03, "it is there")
