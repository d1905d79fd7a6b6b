"""The HAL's backend against emulated servos: what it measures, what it refuses, what it notices."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.equipment.emulated_arm import EmulatedArm, emulated_arm
from bench.equipment.live_robot import wait_for
from fairlead.errors import ConfigError, FairleadError, HardwareError
from fairlead.hal.backend import NotCarriedOutError
from fairlead.hal.frame_check import check_frames
from fairlead.paths import repo_root, robot_dir
from fairlead_hal_so101.calibration import load_calibration
from tests.so101.arm import HOME, ROBOT, as_delivered, backend, ticks, told

pytestmark = pytest.mark.processes


def test_it_takes_hold_where_the_arm_is_and_moves_as_told(sound: EmulatedArm, file: Path) -> None:
    with backend(sound.port, file) as hal:
        start = hal.read()
        np.testing.assert_allclose(start.positions, HOME, atol=0.05)
        assert np.abs(start.velocities).max() < 0.3
        sound.order("pull 1")
        hal.apply(told(0.3))
        wait_for(lambda: abs(hal.read().positions[0] - 0.3) < 0.02, "the goal")
        hal.apply({})
        assert abs(hal.read().positions[0] - 0.3) < 0.05
        sound.order("pull 1 0.0")
        wait_for(lambda: hal.read().efforts[0] > 0.3, "it pushes against the hand")
        hal.apply(told(0.0))


def test_beyond_a_limit_at_rest_it_is_said_once_before_any_row_is_refused(
    sound: EmulatedArm, file: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with backend(sound.port, file, limits={"ticks": 3}) as hal:
        sound.order("temperature 3 66")

        def is_said() -> bool:
            hal.read()
            hal.apply({})
            return bool(caplog.messages)

        wait_for(is_said, "it to be said")
        for _ in range(10):
            is_said()
        sound.order("temperature 3 30")
    said = "servo 3 (elbow_flex): 66 C, limit 60 C: the next row is refused"
    assert caplog.messages == [said]


def test_beyond_a_limit_rows_are_refused_and_the_arm_holds(sound: EmulatedArm, file: Path) -> None:
    with backend(sound.port, file, limits={"ticks": 3}) as hal:
        ticks(hal, 5)
        for line, end, text in (
            ("temperature 3 66", "temperature 3 30", "servo 3 (elbow_flex): 66 C, limit 60 C"),
            ("voltage 9.5", "voltage 12", "servo 1 (shoulder_pan): 9.5 V, limits 10 and 13 V; s"),
            ("overload 3", "overload 3", "servo 3 (elbow_flex): says overload"),
        ):
            sound.order(line)
            with pytest.raises(ConfigError) as caught:
                ticks(hal, 100)
            assert str(caught.value).startswith(f"hal_so101: {text}")
            hal.apply({})
            sound.order(end)
            hal.read()


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("unplug 4", "3 measurements lost in a row: servo 4 (wrist_flex), 5 (wrist_roll), 6 "
         "(gripper) does not answer: its cable, power or id"),
        ("unplug 1", "3 measurements lost in a row: no servo answers: bus cable out, or power off"),
        ("dip", "servo 1 (shoulder_pan), 2 (shoulder_lift), 3 (elbow_flex), 4 (wrist_flex), 5 "
         "(wrist_roll), 6 (gripper): no torque: brown-out or reset? support the arm, look at the "
         "supply, start again"),
    ],
)  # fmt: skip
def test_what_takes_the_arm_away_is_one_clear_fault(
    line: str, text: str, sound: EmulatedArm, file: Path
) -> None:
    with backend(sound.port, file, lost_ticks=2, answer_timeout_s=0.1) as hal:
        before = hal.read()
        sound.order(line)
        with pytest.raises(HardwareError) as caught:
            for _ in range(4):
                assert np.abs(hal.read().positions - before.positions).max() < 0.1
        assert str(caught.value) == f"hal_so101: {text}"


def test_single_errors_of_the_bus_are_no_fault(sound: EmulatedArm, file: Path) -> None:
    with backend(sound.port, file, answer_timeout_s=0.1) as hal:
        for line in ("noise 0.05", "noise 0", "lose 0.02", "lose 0", "late 0.02 150"):
            sound.order(line)
            for _ in range(25):
                with suppress(NotCarriedOutError):
                    ticks(hal, 1)
        assert hal.read().positions == pytest.approx(HOME, abs=0.1)


def test_a_wrong_byte_costs_no_row(sound: EmulatedArm, file: Path) -> None:
    with backend(sound.port, file, answer_timeout_s=0.1) as hal:
        sound.order("noise 0.05")
        ticks(hal, 60)
        assert int(sound.order("wrong")) > 10


def test_rows_that_the_bus_lost_are_no_rows_that_acted(sound: EmulatedArm, file: Path) -> None:
    with backend(sound.port, file, answer_timeout_s=0.1) as hal:
        hal.read()
        sound.order("lose 1")
        hal.read()
        with pytest.raises(NotCarriedOutError, match="nothing was measured, so nothing is told"):
            hal.apply(told(0.03))
        hal.apply({})  # to hold needs no word: each stays at its goal
        sound.order("lose 0")
        hal.read()
        hal.apply({})
        assert hal._setpoints.positions[0] == pytest.approx(0.0, abs=0.01)


def test_a_model_that_is_not_the_described_arm_is_refused(
    sound: EmulatedArm, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copied = shutil.copytree(robot_dir("so101"), tmp_path / "so101")
    model = copied / "so101.xml"
    text = model.read_text(encoding="utf-8")
    link = re.search(r'<body name="wrist_link" pos="([-\d.e]+)', text)
    assert link is not None
    moved = link[0].replace(link[1], f"{float(link[1]) + 0.005}")
    model.write_text(text.replace(link[0], moved), encoding="utf-8")
    monkeypatch.setattr("fairlead.hal.tool_motion.robot_dir", lambda _: copied)
    with backend(sound.port, file) as hal:
        here = hal.read().positions
        with pytest.raises(ConfigError, match="frame wrist_link: 5 mm"):
            check_frames(ROBOT, hal, here, "hal", stands="the start")


@pytest.mark.parametrize("off", [False, True])
def test_torque_is_off_at_the_end_only_where_it_is_asked_for(
    off: bool, sound: EmulatedArm, file: Path
) -> None:
    from rustypot import Sts3215PyController

    with backend(sound.port, file, torque_off_at_exit=off) as hal:
        hal.read()
    servos = Sts3215PyController(str(sound.port), 1_000_000, 0.1)
    assert servos.sync_read_register([1, 6], "torque_enable") == [int(not off)] * 2
    assert servos.sync_read_register([1], "goal_velocity") == [3070]
    servos.close()


KILLED = """
import sys
from pathlib import Path
from tests.so101.arm import backend, told
with backend(Path(sys.argv[1]), Path(sys.argv[2]), torque_off_at_exit=True) as hal:
    goal = 0.0
    while True:
        hal.read()
        goal += 0.02
        hal.apply(told(goal))
        print(goal, flush=True)
"""


def test_a_killed_hal_leaves_each_servo_at_its_last_goal_with_torque(
    sound: EmulatedArm, file: Path
) -> None:
    sound.order("pull 1")
    words = [sys.executable, "-c", KILLED, str(sound.port), str(file)]
    process = subprocess.Popen(words, cwd=repo_root(), stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    with process.stdout as lines:
        while (goal := float(lines.readline())) < 0.4:
            pass
        process.kill()
        last = float((lines.read().split() or [str(goal)])[-1])
    process.wait()
    with backend(sound.port, file) as hal:  # what it sends first is where the arm is
        wait_for(lambda: abs(hal.read().positions[0] - last) < 0.05, "the last goal")
        hal.apply(told(0.0))
        wait_for(lambda: abs(hal.read().positions[0]) < 0.05, "it to be back")
    sound.order("pull 1 0.0")


@pytest.mark.parametrize(
    ("line", "change", "text"),
    [
        ("unplug 6", {}, "{port}: expected STS3215 servos 1, 2, 3, 4, 5, 6 and no others, got 1, "
         "2, 3, 4, 5; look at power, cables and ids"),
        ("plug", {"id": 9}, "{port}: expected STS3215 servos 1, 2, 9, 4, 5, 6 and no others, got "
         "1, 2, 3, 4, 5, 6; look at power, cables and ids"),
        ("plug", {"homing_offset_steps": 7}, "servo 3 (elbow_flex): expected homing_offset 7 "
         "({file}), got 0: another arm, or calibrated elsewhere; fairlead calibrate so101"),
    ],
)  # fmt: skip
def test_another_arm_is_refused(
    line: str, change: dict[str, Any], text: str, sound: EmulatedArm, tmp_path: Path
) -> None:
    sound.order(line)
    file = as_delivered(tmp_path, **change)
    with pytest.raises(FairleadError) as caught, backend(sound.port, file):
        pass
    assert str(caught.value) == f"hal_so101: {text.format(port=sound.port, file=file)}"


def test_a_goal_beyond_the_calibrated_range_moves_nothing(sound: EmulatedArm, file: Path) -> None:
    with backend(sound.port, file) as hal:
        with pytest.raises(ConfigError) as caught:
            hal.apply(told(3.5))
        wanted = "a goal of -3.142 to 3.140 rad, as calibrated, got 3.5"
        assert str(caught.value).startswith(f"hal_so101: joint shoulder_pan: expected {wanted}")
        hal.apply({})
        assert abs(hal.read().positions[0]) < 0.1


def test_a_port_that_is_none_or_goes_away_is_said(tmp_path: Path, file: Path) -> None:
    nowhere = tmp_path / "nowhere"
    with pytest.raises(ConfigError) as refused, backend(nowhere, file):
        pass
    wanted = "expected a serial port that nobody else uses"
    assert str(refused.value).startswith(f"hal_so101: port: {wanted}, got {nowhere}: No such file")
    with emulated_arm(tmp_path / "other") as other, backend(other.port, file) as hal:
        hal.read()
        assert other.process.stdin is not None
        other.process.stdin.write("quit\n")
        other.process.stdin.flush()
        other.process.wait(timeout=30.0)
        with pytest.raises(HardwareError, match="is gone: adapter unplugged?"):
            hal.apply({})
        with pytest.raises(HardwareError, match="is gone: adapter unplugged?"):
            hal.read()


@pytest.mark.parametrize(
    ("edit", "text"),
    [
        (("direction: 1", "direction: 2"), "servos.0.direction: Input should be -1 or 1, got 2"),
        (("id: 2", "id: 1"), "servos: expected a different id for each, got [1, 1, 3, 4, 5, 6]"),
        (
            ("upper_steps: 4095", "upper_steps: 0"),
            "joint 'shoulder_pan': expected lower_steps below",
        ),
        (("joint: gripper", "joint: jaw"), "expected servos of so101: shoulder_pan"),
    ],
)
def test_a_calibration_that_does_not_fit_is_named(
    edit: tuple[str, str], text: str, file: Path
) -> None:
    file.write_text(file.read_text().replace(*edit, 1))
    with pytest.raises(ConfigError) as caught:
        load_calibration(str(file), ROBOT)
    assert text in str(caught.value) and str(file) in str(caught.value)
