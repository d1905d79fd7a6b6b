"""One STS3215 servo without its motor: its memory, its protection, what it measures."""

from __future__ import annotations

import math
from enum import IntFlag
from typing import NamedTuple

STEPS_PER_TURN = 4096
MIDDLE = 2048
STALL_TORQUE_NM = 2.94
"""At 12 V, variant C018: 30 kg cm."""
STALL_CURRENT_A = 2.7
FASTEST_STEPS_S = 3072
"""Without load: 45 rpm."""
CURRENT_UNIT_A = 0.0065
_EEPROM_END = 40
_SRAM_END = 56
_SIZE = 87
_CALIBRATE_MIDDLE = 128


class Register(NamedTuple):
    """Where a number is, its bytes (little-endian), and its value in a new servo."""

    address: int
    size: int
    initial: int = 0
    sign_bit: int | None = None


ID = Register(5, 1, 1)
BAUD_RATE = Register(6, 1, 0)
RETURN_DELAY = Register(7, 1, 0)
RESPONSE_LEVEL = Register(8, 1, 1)
MIN_POSITION = Register(9, 2, 0)
MAX_POSITION = Register(11, 2, 4095)
MAX_TEMPERATURE = Register(13, 1, 70)
MAX_VOLTAGE = Register(14, 1, 140)
MIN_VOLTAGE = Register(15, 1, 40)
MAX_TORQUE = Register(16, 2, 1000)
UNLOADING_CONDITION = Register(19, 1, 44)
PROTECTION_CURRENT = Register(28, 2, 500)
HOMING_OFFSET = Register(31, 2, 0, 11)
PROTECTIVE_TORQUE = Register(34, 1, 20)
PROTECTION_TIME = Register(35, 1, 200)
OVERLOAD_TORQUE = Register(36, 1, 80)
OVERCURRENT_TIME = Register(38, 1, 200)
TORQUE_ENABLE = Register(40, 1, 0)
ACCELERATION = Register(41, 1, 0)
GOAL_POSITION = Register(42, 2, 0, 15)
GOAL_SPEED = Register(46, 2, 0, 15)
TORQUE_LIMIT = Register(48, 2, 1000)
LOCK = Register(55, 1, 1)
PRESENT_POSITION = Register(56, 2, MIDDLE, 15)
PRESENT_SPEED = Register(58, 2, 0, 15)
PRESENT_LOAD = Register(60, 2, 0, 10)
PRESENT_VOLTAGE = Register(62, 1, 120)
PRESENT_TEMPERATURE = Register(63, 1, 30)
STATUS = Register(65, 1, 0)
MOVING = Register(66, 1, 0)
PRESENT_CURRENT = Register(69, 2, 0, 15)
_NAMED = [one for one in dict(globals()).values() if isinstance(one, Register)]
_FIRMWARE, _MODEL = {0: 3, 1: 10}, {3: 0x09, 4: 0x03}
_OTHERS = {18: 12, 20: 47, 21: 32, 22: 32, 24: 16, 26: 1, 27: 1, 30: 1, 37: 10, 39: 10, 80: 1}
"""Of a new servo, by address: what changes nothing here."""


BAUD_RATES = (1_000_000, 500_000, 250_000, 128_000, 115_200, 76_800, 57_600, 38_400)
"""[bit/s] by the value of register BAUD_RATE."""


class Fault(IntFlag):
    """Bits of register STATUS and of the error byte of every answer."""

    VOLTAGE = 1
    SENSOR = 2
    OVERHEAT = 4
    OVERCURRENT = 8
    OVERLOAD = 32


class Sts3215:
    """A servo's registers, and what follows from them.

    What a host writes into the EEPROM holds at once, and after the power was off only if LOCK
    was 0 when it was written.

    Args:
        servo_id: as a host has set it.

    Attributes:
        turned_rad: how far its shaft is from where its encoder reads 2048.
        voltage, temperature_c: what it measures.
        sensor_fails: its encoder is broken.
    """

    def __init__(self, servo_id: int) -> None:
        self._memory = bytearray(_SIZE)
        for address, value in (_FIRMWARE | _MODEL | _OTHERS).items():
            self._memory[address] = value
        for register in _NAMED:
            self._put(register, register.initial)
        self._put(ID, servo_id)
        self._saved = bytes(self._memory[:_EEPROM_END])
        self._waiting: tuple[int, bytes] | None = None
        self._overloaded_s = self._overcurrent_s = 0.0
        self._latched = Fault(0)
        self.turned_rad = 0.0
        self.voltage, self.temperature_c, self.sensor_fails = 12.0, 30.0, False

    def get(self, register: Register) -> int:
        """The number in a register, with its sign."""
        data = self._memory[register.address : register.address + register.size]
        value = int.from_bytes(data, "little")
        if register.sign_bit is None:
            return value
        size = value & ((1 << register.sign_bit) - 1)
        return -size if value >> register.sign_bit & 1 else size

    def read(self, address: int, count: int) -> bytes:
        """Bytes of the memory; 0 beyond its end."""
        return bytes(self._memory[address : address + count]).ljust(count, b"\0")

    def write(self, address: int, data: bytes) -> None:
        """What a host writes; what is read-only stays as it is.

        A goal switches torque on, as the firmware does:
        https://github.com/huggingface/lerobot/issues/3585
        """
        enabled = self.get(TORQUE_ENABLE)
        for place, value in enumerate(data, start=address):
            if ID.address <= place < _SRAM_END:
                self._memory[place] = value
        if not self.get(LOCK):
            self._saved = bytes(self._memory[:_EEPROM_END])
        if address <= GOAL_POSITION.address < address + len(data):
            self._put(TORQUE_ENABLE, 1)
        if address <= TORQUE_ENABLE.address < address + len(data):
            self._latched, self._overloaded_s, self._overcurrent_s = Fault(0), 0.0, 0.0
            if self.get(TORQUE_ENABLE) == _CALIBRATE_MIDDLE:
                self._put(TORQUE_ENABLE, enabled)
                self._put(HOMING_OFFSET, _shortest(self._encoder() - MIDDLE))
                self._saved = bytes(self._memory[:_EEPROM_END])
        self.measure(0.0, 0.0)

    def register_write(self, address: int, data: bytes) -> None:
        """Keep a write until `act`."""
        self._waiting = (address, data)

    def act(self) -> None:
        """Carry out what `register_write` kept."""
        if self._waiting is not None:
            self.write(*self._waiting)
            self._waiting = None

    def power_up(self) -> None:
        """As after the power was off: torque off, the EEPROM as it was saved."""
        self._memory[:_EEPROM_END] = self._saved
        for register in _NAMED:
            if register.address >= _EEPROM_END:
                self._put(register, register.initial)
        self._put(TORQUE_LIMIT, self.get(MAX_TORQUE))
        self._waiting, self._latched = None, Fault(0)
        self._overloaded_s = self._overcurrent_s = 0.0
        self.measure(0.0, 0.0)
        self._put(GOAL_POSITION, self.get(PRESENT_POSITION))

    @property
    def faults(self) -> Fault:
        """What is wrong with it now."""
        tenths = round(self.voltage * 10)
        found = self._latched
        if not self.get(MIN_VOLTAGE) <= tenths <= self.get(MAX_VOLTAGE):
            found |= Fault.VOLTAGE
        if self.temperature_c > self.get(MAX_TEMPERATURE):
            found |= Fault.OVERHEAT
        return found | (Fault.SENSOR if self.sensor_fails else Fault(0))

    @property
    def goal_rad(self) -> float:
        """Where the shaft is told to turn, as `turned_rad`."""
        lowest, highest = self.get(MIN_POSITION), self.get(MAX_POSITION)
        goal = self.get(GOAL_POSITION)
        if lowest or highest:
            goal = min(max(goal, lowest), highest)
        steps = goal - self._position()
        return self.turned_rad + steps * 2 * math.pi / STEPS_PER_TURN

    @property
    def torque_nm(self) -> float:
        """The most it pushes with now; 0: it is limp."""
        protection = self.faults & self.get(UNLOADING_CONDITION)
        if self.get(TORQUE_ENABLE) != 1 or protection & ~Fault.OVERLOAD:
            return 0.0
        share = self.get(TORQUE_LIMIT) / 1000
        if protection:
            share = min(share, self.get(PROTECTIVE_TORQUE) / 100)
        return STALL_TORQUE_NM * share

    def overload(self) -> None:
        """As if it had been blocked for longer than its protection time."""
        self._latched |= Fault.OVERLOAD

    def strain(self, torque_nm: float, period_s: float) -> None:
        """It pushed with ``torque_nm`` for ``period_s``."""
        share = abs(torque_nm) / STALL_TORQUE_NM
        heavy = 100 * share > self.get(OVERLOAD_TORQUE)
        self._overloaded_s = self._overloaded_s + period_s if heavy else 0.0
        if self._overloaded_s > 0.01 * self.get(PROTECTION_TIME):
            self._latched |= Fault.OVERLOAD
        too_much = share * STALL_CURRENT_A > self.get(PROTECTION_CURRENT) * CURRENT_UNIT_A
        self._overcurrent_s = self._overcurrent_s + period_s if too_much else 0.0
        if self._overcurrent_s > 0.01 * self.get(OVERCURRENT_TIME):
            self._latched |= Fault.OVERCURRENT

    def measure(self, speed_rad_s: float, torque_nm: float) -> None:
        """Write what it measures into its registers."""
        share = torque_nm / STALL_TORQUE_NM
        speed = round(speed_rad_s * STEPS_PER_TURN / (2 * math.pi))
        self._put(PRESENT_POSITION, self._position())
        self._put(PRESENT_SPEED, speed)
        self._put(PRESENT_LOAD, round(1000 * share))
        self._put(PRESENT_VOLTAGE, round(self.voltage * 10))
        self._put(PRESENT_TEMPERATURE, round(self.temperature_c))
        self._put(STATUS, int(self.faults))
        self._put(MOVING, int(abs(speed) > 1))
        self._put(PRESENT_CURRENT, round(share * STALL_CURRENT_A / CURRENT_UNIT_A))

    def _put(self, register: Register, value: int) -> None:
        if register.sign_bit is not None and value < 0:
            value = -value | 1 << register.sign_bit
        end = register.address + register.size
        self._memory[register.address : end] = value.to_bytes(register.size, "little")

    def _encoder(self) -> int:
        return MIDDLE + round(self.turned_rad * STEPS_PER_TURN / (2 * math.pi))

    def _position(self) -> int:
        return (self._encoder() - self.get(HOMING_OFFSET)) % STEPS_PER_TURN


def _shortest(steps: int) -> int:
    half = STEPS_PER_TURN // 2
    return max((steps + half) % STEPS_PER_TURN - half, 1 - half)
