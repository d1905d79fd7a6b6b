"""What could wake servos, or move them, without a row: a start, a brown-out, a lost packet."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.equipment.emulated_arm import EmulatedArm
from bench.equipment.live_robot import wait_for
from fairlead.errors import FairleadError, HardwareError
from fairlead.hal.backend import NotCarriedOutError
from tests.so101.arm import backend, heard_ticks, ticks, told

pytestmark = pytest.mark.processes


def torques(arm: EmulatedArm) -> list[int]:
    from rustypot import Sts3215PyController

    servos = Sts3215PyController(str(arm.port), 1_000_000, 0.4)
    found: list[int] = servos.sync_read_register([1, 2, 3, 4, 5, 6], "torque_enable")
    servos.close()
    return found


def test_servos_that_started_anew_are_told_nothing_any_more(sound: EmulatedArm, file: Path) -> None:
    with backend(sound.port, file) as hal:
        heard_ticks(hal, 3)
        sound.order("dip")
        with pytest.raises(HardwareError, match="no torque: brown-out or reset"):
            hal.read()
        for _ in range(3):  # as the host holds after a fault
            with pytest.raises(HardwareError, match="not seen"):
                hal.apply({})
    assert torques(sound) == [0] * 6


def test_a_measurement_is_good_for_one_write(sound: EmulatedArm, file: Path) -> None:
    """After a fault nobody measures: an arm that is switched off and on may not wake."""
    with backend(sound.port, file) as hal:
        heard_ticks(hal, 3)
        sound.order("dip")
        with pytest.raises(HardwareError, match="not seen"):
            hal.apply({})
    assert torques(sound) == [0] * 6


def test_a_tick_that_measured_nothing_tells_nothing(sound: EmulatedArm, file: Path) -> None:
    """What starts anew between a lost measurement and the tick's goals would move unlimited."""
    with backend(sound.port, file) as hal:
        heard_ticks(hal, 3)
        sound.order("lose 1")
        hal.read()
        sound.order("dip")
        with pytest.raises(NotCarriedOutError):
            hal.apply(told())
        sound.order("lose 0")
        with pytest.raises(HardwareError, match="no torque: brown-out or reset"):
            hal.read()
    assert torques(sound) == [0] * 6


def test_servos_that_a_goal_woke_without_their_limits_are_a_fault(
    sound: EmulatedArm, file: Path
) -> None:
    with backend(sound.port, file) as hal:
        hal.read()
        sound.order("dip")
        hal.apply(told())
        with pytest.raises(HardwareError, match="no torque: brown-out or reset"):
            hal.read()


def test_an_old_goal_moves_nothing_at_the_start_whatever_packets_get_lost(
    sound: EmulatedArm, file: Path
) -> None:
    with backend(sound.port, file, torque_off_at_exit=True) as hal:
        ticks(hal, 3)
    sound.order("pull 1 0.8")
    wait_for(lambda: abs(float(sound.order("where 1")) - 0.8) < 0.01, "the hand to take it there")
    sound.order("deaf 0.15")
    try:
        with backend(sound.port, file, answer_timeout_s=0.1) as hal:
            sound.order("deaf 0")
            sound.order("pull 1")
            for _ in range(20):
                hal.read()
                hal.apply({})
            assert abs(hal.read().positions[0] - 0.8) < 0.05
    except FairleadError as error:  # refused: then nothing has been let go
        assert "hal_so101" in str(error)
    sound.order("pull 1 0.0")


def test_servos_push_little_more_than_what_the_gate_takes_for_a_contact(
    sound: EmulatedArm, file: Path
) -> None:
    from rustypot import Sts3215PyController

    with backend(sound.port, file, "hardware"):
        pass
    servos = Sts3215PyController(str(sound.port), 1_000_000, 0.4)
    assert servos.sync_read_register([1], "torque_limit") == [625]  # 1.25 * 1.47 of 2.94 N m
    servos.close()
