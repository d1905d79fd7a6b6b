"""The emulated servos, asked by two libraries that this project did not write."""

from __future__ import annotations

import os
import select
import timeit
from collections.abc import Iterator

import pytest
import scservo_sdk
from rustypot import Sts3215PyController

from bench.equipment.emulated_arm import EmulatedArm, emulated_arm
from bench.equipment.live_robot import wait_for
from fairlead_tools.emulate.sts_packets import status_packet, take_request

IDS = [1, 2, 3, 4, 5, 6]

pytestmark = pytest.mark.processes


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmulatedArm]:
    with emulated_arm(tmp_path_factory.mktemp("emulator")) as found:
        yield found


@pytest.fixture
def servos(arm: EmulatedArm) -> Iterator[Sts3215PyController]:
    """Each test finds the arm as it is after it was switched on."""
    for line in ("plug", "noise 0", "lose 0", "late 0 0", "voltage 12", "dip"):
        assert arm.order(line) == f"done: {line}"
    controller = Sts3215PyController(str(arm.port), 1_000_000, 0.05)
    yield controller
    controller.close()


@pytest.fixture
def maker(arm: EmulatedArm) -> Iterator[scservo_sdk.sms_sts]:
    """The maker's own library."""
    port = scservo_sdk.PortHandler(str(arm.port))
    assert port.openPort()
    yield scservo_sdk.sms_sts(port)
    port.closePort()


def test_every_servo_is_found_and_has_every_register_of_the_library(
    servos: Sts3215PyController,
) -> None:
    wait_for(lambda: servos.scan(list(range(10))) == dict.fromkeys(IDS, 777), "all servos")
    values = {one.name: servos.sync_read_register(IDS, one.name) for one in servos.registers()}
    assert values["id"] == IDS
    assert values["baud_rate"] == [0] * 6
    assert values["lock"] == [1] * 6
    assert values["present_voltage"] == [120] * 6
    assert values["max_temperature_limit"] == [70] * 6


def test_a_joint_goes_to_its_goal_at_the_speed_it_is_told(servos: Sts3215PyController) -> None:
    servos.write_register(1, "goal_position", 2048)
    servos.write_register(1, "torque_enable", 1)
    wait_for(lambda: abs(servos.read_register(1, "present_position") - 2048) <= 3, "its start")
    servos.write_register(1, "goal_velocity", 500)
    servos.sync_write_register([1], "goal_position", [2348])
    fastest = 0

    def arrives() -> bool:
        nonlocal fastest
        fastest = max(fastest, servos.read_register(1, "present_velocity"))
        return abs(servos.read_register(1, "present_position") - 2348) <= 3

    wait_for(arrives, "the goal")
    assert 400 < fastest < 600


def test_the_makers_library_reads_writes_and_registers_writes(
    arm: EmulatedArm, servos: Sts3215PyController, maker: scservo_sdk.sms_sts
) -> None:
    assert maker.ping(3) == (777, scservo_sdk.COMM_SUCCESS, 0)
    assert maker.ping(9)[1] == scservo_sdk.COMM_RX_TIMEOUT
    assert maker.RegWritePosEx(2, 1500, 200, 50) == (scservo_sdk.COMM_SUCCESS, 0)
    assert servos.read_register(2, "goal_position") != 1500
    maker.RegAction()
    assert servos.read_register(2, "goal_position") == 1500
    assert servos.read_register(2, "acceleration") == 50
    for servo_id in IDS:
        assert maker.SyncWritePosEx(servo_id, 2000 + servo_id, 300, 20)
    maker.groupSyncWrite.txPacket()
    assert servos.sync_read_register(IDS, "goal_position") == [2000 + one for one in IDS]
    group = scservo_sdk.GroupSyncRead(maker, scservo_sdk.SMS_STS_PRESENT_POSITION_L, 15)
    assert all(group.addParam(servo_id) for servo_id in IDS)
    assert group.txRxPacket() == scservo_sdk.COMM_SUCCESS
    read = [group.getData(one, scservo_sdk.SMS_STS_PRESENT_POSITION_L, 2) for one in IDS]
    assert read == pytest.approx(servos.sync_read_register(IDS, "present_position"), abs=20)


def test_what_is_written_under_the_lock_is_gone_after_the_power_was(
    arm: EmulatedArm, servos: Sts3215PyController, maker: scservo_sdk.sms_sts
) -> None:
    servos.write_register(4, "max_temperature_limit", 60)
    assert servos.read_register(4, "max_temperature_limit") == 60
    arm.order("dip")
    assert servos.read_register(4, "max_temperature_limit") == 70
    assert maker.unLockEprom(4) == (scservo_sdk.COMM_SUCCESS, 0)
    servos.write_register(4, "max_temperature_limit", 60)
    maker.LockEprom(4)
    servos.write_register(4, "torque_enable", 1)
    arm.order("dip")
    assert servos.read_register(4, "max_temperature_limit") == 60
    assert servos.read_register(4, "torque_enable") == 0


@pytest.mark.parametrize(
    ("line", "register", "value", "bit"),
    [
        ("voltage 3.5", "present_voltage", 35, 1),
        ("temperature 2 75", "present_temperature", 75, 4),
        ("overload 2", "status", 32, 32),
        ("sensor 2", "status", 2, 2),
    ],
)
def test_a_fault_is_in_its_register_and_in_every_answer(
    line: str, register: str, value: int, bit: int, arm: EmulatedArm, servos: Sts3215PyController
) -> None:
    assert arm.order(line) == f"done: {line}"
    wait_for(lambda: servos.read_register(2, register) == value, register)
    assert servos.sync_read_register_with_error([2], "status")[0][1] & bit
    arm.order("temperature 2 30")


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("noise 1", "motor 1: "),
        ("lose 1", "motor 1: Operation timed out"),
        ("late 1 100", "motor 1: Operation timed out"),
        ("unplug 4", "motor 4: Operation timed out"),
    ],
)
def test_a_bus_fault_is_an_error_of_the_library(
    line: str, complaint: str, arm: EmulatedArm, servos: Sts3215PyController
) -> None:
    assert servos.sync_read_register(IDS, "id") == IDS
    assert arm.order(line) == f"done: {line}"
    with pytest.raises(RuntimeError) as caught:
        servos.sync_read_register(IDS, "id")
    assert str(caught.value).startswith(complaint)


def test_at_another_rate_nobody_answers(servos: Sts3215PyController) -> None:
    servos.set_baudrate(115_200)
    assert servos.scan(IDS) == {}
    servos.set_baudrate(1_000_000)
    assert servos.sync_read_register(IDS, "id") == IDS


def test_answers_come_no_faster_than_the_bus_is(servos: Sts3215PyController) -> None:
    shortest = min(timeit.repeat(lambda: servos.sync_read_raw_data(IDS, 56, 15), number=1))
    assert shortest >= 10e-6 * (8 + len(IDS) + len(IDS) * (6 + 15))


def test_a_wrong_checksum_is_not_answered(arm: EmulatedArm, servos: Sts3215PyController) -> None:
    port = os.open(arm.port, os.O_RDWR | os.O_NOCTTY)
    os.write(port, bytes.fromhex("ffff010201fc"))
    assert not select.select([port], [], [], 0.05)[0]
    os.write(port, bytes.fromhex("ffff010201fb"))
    assert select.select([port], [], [], 5.0)[0]
    assert os.read(port, 100) == bytes.fromhex("ffff010200fc")
    os.close(port)


def test_order_that_is_none_says_what_there_is(arm: EmulatedArm) -> None:
    assert arm.order("nois 1").startswith("ERROR emulate: expected an order, got 'nois' (valid: ")
    assert arm.order("noise 2") == "ERROR emulate: expected SHARE from 0 to 1, got 2.0"
    assert arm.order("pull 7 1") == "ERROR emulate: expected an ID from 1 to 6, got 7.0"
    assert arm.order("late 1") == "ERROR emulate: late: expected late SHARE MS, got 'late 1'"


def test_packets_are_found_among_noise_byte_by_byte() -> None:
    ping = bytes.fromhex("ffff010201fb")  # the manual's example
    received, found = bytearray(), []
    for byte in b"\x00\xff\x17" + b"\xff" + ping + ping[:-1] + b"\x00" + ping:
        received.append(byte)
        request = take_request(received)
        found += [request] if request else []
    assert [(one.servo_id, one.instruction, one.size) for one in found] == [(1, 1, 6)] * 2
    assert status_packet(1, 0) == bytes.fromhex("ffff010200fc")
