"""A leader arm is read only, and only if it is the one that was calibrated, and limp."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rustypot

from bench.equipment.emulated_arm import EmulatedArm, emulated_arm
from fairlead.errors import ConfigError
from fairlead.messages import FloatArray
from fairlead_hal_so101 import LimpArm, LostAnswerError
from fairlead_hal_so101.limp_arm import disbelieved
from fairlead_hal_so101.servo_reading import ServoFault, ServoReading
from tests.so101.arm import ROBOT, as_delivered, backend
from tests.so101.calibrating import calibrate, move

HOME = [0.0, -1.0, 0.9, 0.7, 0.0, 0.3]

pytestmark = pytest.mark.processes


@pytest.fixture
def arm(tmp_path: Path) -> Iterator[EmulatedArm]:
    with emulated_arm(tmp_path / "arm") as found:
        yield found


@pytest.fixture
def file(tmp_path: Path) -> str:
    return str(as_delivered(tmp_path, "leader"))


def write(arm: EmulatedArm, servo_id: int, register: str, value: int) -> None:
    controller = rustypot.Sts3215PyController(str(arm.port), 1_000_000, 0.4)
    controller.write_register(servo_id, register, value, 3)
    controller.close()


def read(leader: LimpArm) -> FloatArray:
    """A reading; on a busy machine one may be lost."""
    for _ in range(50):
        try:
            return leader.read()
        except LostAnswerError as error:
            reason = str(error)
    raise AssertionError(reason)


def test_its_joints_are_read_and_its_trigger_as_a_share_of_its_own_way(
    arm: EmulatedArm, tmp_path: Path
) -> None:
    """A trigger that moves from 0.2 to 0.9 where a jaw does from -0.17 to 1.75."""
    file = tmp_path / "mine.yaml"
    code, said = calibrate(arm, file, "--arm", "leader", trigger=(0.2, 0.9))
    assert code == 0 and said.endswith(f"--calibration {file}"), said
    for servo_id, position in enumerate([*HOME[:5], 0.55], start=1):
        move(arm, servo_id, position)
    leader = LimpArm(ROBOT, str(arm.port), str(file))
    np.testing.assert_allclose(read(leader), [*HOME[:5], 0.5], atol=0.06)
    leader.close()
    with pytest.raises(ConfigError, match="expected a follower's calibration .*, got a leader's"):
        backend(arm.port, file).__enter__()


def test_one_that_has_torque_or_another_calibration_is_refused(
    arm: EmulatedArm, file: str, tmp_path: Path
) -> None:
    write(arm, 4, "torque_enable", 1)
    wanted = r"limp arm \(switch its power off and on\), got torque in servo 4 \(wrist_flex\); is"
    with pytest.raises(ConfigError, match=wanted):
        LimpArm(ROBOT, str(arm.port), file)
    write(arm, 4, "torque_enable", 0)
    LimpArm(ROBOT, str(arm.port), file).close()
    changed = str(as_delivered(tmp_path, "leader", homing_offset_steps=100))
    with pytest.raises(ConfigError, match="leader arm: servo 3 .*expected homing_offset 100"):
        LimpArm(ROBOT, str(arm.port), changed)
    with pytest.raises(ConfigError, match="no calibration .* fairlead calibrate so101 .* leader$"):
        LimpArm(ROBOT, str(arm.port), str(tmp_path / "none.yaml"))
    with pytest.raises(ConfigError, match="expected a leader's calibration .* got a follower's"):
        LimpArm(ROBOT, str(arm.port), str(as_delivered(tmp_path)))


def test_a_reading_that_cannot_be_right_is_named(arm: EmulatedArm, tmp_path: Path) -> None:
    write(arm, 3, "max_position_limit", 2300)
    leader = LimpArm(ROBOT, str(arm.port), str(as_delivered(tmp_path, "leader", upper_steps=2300)))
    with pytest.raises(LostAnswerError, match=r"servo 3 \(elbow_flex\): reads \d+, calibrated"):
        until_named(leader)
    arm.order("sensor 2")
    with pytest.raises(LostAnswerError, match=r"servo 2 \(shoulder_lift\): says that its encoder"):
        until_named(leader)
    leader.close()


def until_named(leader: LimpArm) -> None:
    """Read, until what is wrong is no answer that was lost on a busy machine."""
    for _ in range(50):
        try:
            leader.read()
        except LostAnswerError as error:
            if "timed out" not in str(error):
                raise


@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        ({}, ""),
        ({"faults": ServoFault.VOLTAGE | ServoFault.OVERLOAD}, ""),
        ({"faults": ServoFault.SENSOR}, "says that its encoder is broken"),
        ({"has_torque": True}, "has torque: it is not limp any more"),
        ({"position_steps": 3150}, ""),
        ({"position_steps": 3151}, "reads 3151, calibrated 1000 to 3000 steps"),
        ({"position_steps": 850}, ""),
        ({"position_steps": 849}, "reads 849, calibrated 1000 to 3000 steps"),
    ],
)
def test_what_is_not_believed_of_a_servo(change: dict[str, Any], wrong: str) -> None:
    reading = ServoReading(
        has_torque=False,
        acceleration=0,
        goal_steps=2048,
        goal_velocity=0,
        position_steps=2048,
        speed_steps_s=0,
        load=0.0,
        voltage_v=7.4,
        temperature_c=30,
        current_a=0.0,
        effort_nm=0.0,
        faults=ServoFault(0),
    )
    assert disbelieved(dataclasses.replace(reading, **change), 1000, 3000) == wrong
