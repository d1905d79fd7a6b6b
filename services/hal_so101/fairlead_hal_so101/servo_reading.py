"""What a servo's registers say, in SI units, and whether it is what they may."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntFlag

from fairlead_hal_so101.options import ServoLimits

FIRST, LENGTH = 40, 31
"""Registers 40 to 70: torque, goal, and everything that is measured."""
_LAYOUT = struct.Struct("<BBHHHH5xBHHHBBxBB2xH")
_CURRENT_UNIT_A = 0.0065
STALL_NM = 2.94
"""12 V variant: 30 kg cm."""
_STALL_NM_PER_A = STALL_NM / 2.7
"""An estimate: friction is not in it."""


class ServoFault(IntFlag):
    """Bits of the error byte in every answer."""

    VOLTAGE = 1
    SENSOR = 2
    OVERHEAT = 4
    OVERCURRENT = 8
    OVERLOAD = 32


@dataclass(frozen=True)
class ServoReading:
    """One servo at one moment.

    acceleration, goal_velocity: its limits as registers have them, 0: none. goal_steps,
    position_steps, speed_steps_s: as the servo counts. load: share of its full duty cycle, with
    sign. effort_nm: estimated from the current.
    """

    has_torque: bool
    acceleration: int
    goal_steps: int
    goal_velocity: int
    position_steps: int
    speed_steps_s: int
    load: float
    voltage_v: float
    temperature_c: int
    current_a: float
    effort_nm: float
    faults: ServoFault


def servo_reading(data: bytes, error: int) -> ServoReading:
    """Decode registers 40 to 70 and the error byte."""
    (torque, acceleration, goal, _, goal_velocity, _, _, position, speed, load, volts, celsius, _,
     _, amperes) = _LAYOUT.unpack(data)  # fmt: skip
    current_a = abs(_signed(amperes, 15)) * _CURRENT_UNIT_A
    signed_load = _signed(load, 10) / 1000
    effort = current_a * _STALL_NM_PER_A * (-1 if signed_load < 0 else 1)
    return ServoReading(
        has_torque=torque == 1,
        acceleration=acceleration,
        goal_steps=_signed(goal, 15),
        goal_velocity=_signed(goal_velocity, 15),
        position_steps=_signed(position, 15),
        speed_steps_s=_signed(speed, 15),
        load=signed_load,
        voltage_v=volts / 10,
        temperature_c=celsius,
        current_a=current_a,
        effort_nm=effort,
        faults=ServoFault(error & sum(ServoFault)),
    )


def _signed(value: int, sign_bit: int) -> int:
    size = value & ((1 << sign_bit) - 1)
    return -size if value >> sign_bit & 1 else size


class ServoHealth:
    """Counts for how many ticks in a row each servo was beyond a limit.

    Args:
        names: of the servos, for what is said.

    Attributes:
        complaint: what is wrong now, "" if nothing is.
    """

    def __init__(self, names: Sequence[str], limits: ServoLimits) -> None:
        self._names, self._limits = names, limits
        self._beyond: dict[tuple[int, str], int] = {}
        self.complaint = ""

    def look(self, readings: Sequence[ServoReading]) -> None:
        """Take one tick's measurements."""
        found = {
            (index, kind): text
            for index, reading in enumerate(readings)
            for kind, text in self._findings(reading)
        }
        self._beyond = {key: self._beyond.get(key, 0) + 1 for key in found}
        lasting = [key for key, ticks in self._beyond.items() if ticks >= self._limits.ticks]
        self.complaint = "; ".join(f"servo {self._names[key[0]]}: {found[key]}" for key in lasting)

    def _findings(self, reading: ServoReading) -> Iterator[tuple[str, str]]:
        limits = self._limits
        low, high = limits.voltage_v
        if reading.faults:
            yield "faults", f"says {' and '.join(one.name or '' for one in reading.faults).lower()}"
        if reading.temperature_c > limits.temperature_c:
            yield "heat", f"{reading.temperature_c} C, limit {limits.temperature_c:g} C"
        if not low <= reading.voltage_v <= high:
            yield "voltage", f"{reading.voltage_v:g} V, limits {low:g} and {high:g} V"
        if reading.current_a > limits.current_a:
            yield "current", f"{reading.current_a:.2f} A, limit {limits.current_a:g} A"
        if abs(reading.load) > limits.load:
            yield "load", f"load {abs(reading.load):.2f}, limit {limits.load:g}"
